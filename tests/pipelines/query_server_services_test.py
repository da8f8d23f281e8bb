#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a server offers besides the protocol of models: gRPC's services of health and reflection, as Python's grpcio uses them."""

import time
import unittest

import grpc
import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool

import http2_peer
import tap_runner
from served_pipeline import Client, Pipeline, pb, request, status_of

FLOATS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"
X = np.array([[1.5, -2, 0, 1e6]], np.float32)
WATCH = "/grpc.health.v1.Health/Watch"
SERVING, NOT_SERVING, UNKNOWN = b"\x08\x01", b"\x08\x02", b"\x08\x03"


def bare(message_type):
    """Without the names for JSON, which the descriptions of Python's classes do not have."""
    for field in message_type.field:
        field.ClearField("json_name")
    for nested in message_type.nested_type:
        bare(nested)
    return message_type


class Services(unittest.TestCase):
    def serve(self, options=""):
        pipeline = Pipeline(f"tensor_query_serversrc protocol=oip port=0 model-name=same {options} {FLOATS} ! tensor_query_serversink")
        self.addCleanup(pipeline.stop)
        self.assertTrue(pipeline.port, "".join(pipeline.lines))
        return pipeline

    def client(self, pipeline):
        client = Client(f"127.0.0.1:{pipeline.port}")
        self.addCleanup(client.close)
        client.wait_until_ready("same")
        return client

    def watch(self, client, service=b"", seconds=60):
        message = b"\x0a" + bytes([len(service)]) + service if service else b""
        return client.channel.unary_stream(WATCH)(message, timeout=seconds)


class Health(Services):
    def test_watchers_get_the_health_and_its_changes(self):
        pipeline = self.serve()
        client = self.client(pipeline)
        calls = [self.watch(client, service) for service in (b"", b"same", b"inference.GRPCInferenceService")]
        for call in calls:
            self.assertEqual(next(call), SERVING)
        pipeline.interrupt()
        for call in calls:
            self.assertEqual(next(call), NOT_SERVING)
            code, _ = status_of(lambda call=call: list(call))
            self.assertEqual(code, "UNAVAILABLE")

    def test_a_service_that_is_not_there_is_unknown(self):
        client = self.client(self.serve())
        self.assertEqual(next(self.watch(client, b"other")), UNKNOWN)

    def test_watchers_take_no_place_of_requests_and_are_limited_themselves(self):
        client = self.client(self.serve("max-requests=1"))
        calls = [self.watch(client) for _ in range(4)]
        self.assertEqual([next(call) for call in calls], [SERVING] * 4)
        self.assertEqual(status_of(lambda: list(self.watch(client))),
                         ("RESOURCE_EXHAUSTED", "this connection has 4 streams, such as those that watch health"))
        self.assertEqual(client.infer(request("same", X)).raw_output_contents[0], X.tobytes())
        for call in calls:
            call.cancel()
        end = time.monotonic() + 30
        while status_of(lambda: next(self.watch(client)))[0] != "OK":  # once the server knows of the cancellations
            self.assertLess(time.monotonic(), end)

    def test_a_watcher_ends_at_its_deadline(self):
        call = self.watch(self.client(self.serve()), seconds=3)
        self.assertEqual(next(call), SERVING)
        self.assertEqual(status_of(lambda: list(call))[0], "DEADLINE_EXCEEDED")

    def test_a_stream_without_a_message_ends(self):
        peer = http2_peer.Connection(self.serve().port)
        self.addCleanup(peer.close)
        stream = peer.call(WATCH)
        end = time.monotonic() + 60
        while stream.reset is None and not peer.closed and time.monotonic() < end:
            peer.read(1)
        self.assertIsNotNone(stream.reset)
        self.assertFalse(peer.closed)

    def test_messages_that_cannot_be_read_are_refused(self):
        client = self.client(self.serve())
        code, text = status_of(lambda: list(client.channel.unary_stream(WATCH)(b"\x0a\xff", timeout=30)))
        self.assertEqual(code, "INVALID_ARGUMENT")
        self.assertIn("a damaged request for a model", text)


class Reflection(Services):
    """The messages of reflection are made of the server's own description of them, after the first, which is written by hand."""

    VERSIONS = ("v1alpha", "v1")

    def ask(self, client, version, *messages):
        path = f"/grpc.reflection.{version}.ServerReflection/ServerReflectionInfo"
        return list(client.channel.stream_stream(path)(iter(messages), timeout=30))

    def file_of(self, client, version, symbol):
        """The FileDescriptorProto of a response: field 4, which has field 1."""
        response, = self.ask(client, version, b"\x22" + bytes([len(symbol)]) + symbol)
        at = response.index(b"\x22", 2 + response[1])  # after field 2, the request
        size, used = 0, 0
        for used, byte in enumerate(response[at + 1:at + 4]):
            size |= (byte & 127) << (7 * used)
            if byte < 128:
                break
        inner = response[at + 2 + used:at + 2 + used + size]
        skip = 1 + next(i for i, byte in enumerate(inner[1:]) if byte < 128) + 1
        out = descriptor_pb2.FileDescriptorProto()
        out.ParseFromString(inner[skip:])
        return out

    def classes(self, file, *names):
        pool = descriptor_pool.DescriptorPool()
        pool.Add(file)
        found = [pool.FindMessageTypeByName(name) for name in names]
        try:
            from google.protobuf import message_factory
            return [message_factory.MessageFactory(pool).GetPrototype(one) for one in found]
        except AttributeError:
            return [message_factory.GetMessageClass(one) for one in found]

    def messages(self, client, version):
        package = f"grpc.reflection.{version}"
        file = self.file_of(client, version, f"{package}.ServerReflection".encode())
        return self.classes(file, f"{package}.ServerReflectionRequest", f"{package}.ServerReflectionResponse")

    def test_services_are_listed(self):
        client = self.client(self.serve())
        for version in self.VERSIONS:
            asked, answered = self.messages(client, version)
            question = asked(host="here", list_services="*")
            response = answered.FromString(self.ask(client, version, question.SerializeToString())[0])
            self.assertEqual((response.valid_host, response.original_request), ("here", question))
            self.assertEqual([service.name for service in response.list_services_response.service],
                             ["inference.GRPCInferenceService", "grpc.health.v1.Health", "grpc.reflection.v1.ServerReflection",
                              "grpc.reflection.v1alpha.ServerReflection"])

    def test_a_client_calls_what_it_knows_by_reflection_alone(self):
        client = self.client(self.serve())
        file = self.file_of(client, "v1alpha", b"inference.GRPCInferenceService")
        service, = file.service
        method, = [method for method in service.method if method.name == "ModelInfer"]
        asked, answered = self.classes(file, method.input_type[1:], method.output_type[1:])
        call = client.channel.unary_unary(f"/{file.package}.{service.name}/{method.name}", asked.SerializeToString, answered.FromString)
        message = asked(model_name="same", raw_input_contents=[X.tobytes()])
        message.inputs.add(name="input", datatype="FP32", shape=[1, 4])
        self.assertEqual(call(message, timeout=30).raw_output_contents[0], X.tobytes())

    def test_the_description_is_that_of_the_protocol(self):
        """Every field that the tests' own description of the protocol has is there with its number and type."""
        own = descriptor_pb2.FileDescriptorProto()
        pb.DESCRIPTOR.CopyToProto(own)
        file = self.file_of(self.client(self.serve()), "v1", b"inference.ModelInferRequest.InferInputTensor")
        types = {one.name: one for one in file.message_type}
        for wanted in own.message_type:
            self.assertEqual(bare(types[wanted.name]), wanted)
        names = {method.name for method in file.service[0].method}
        self.assertLessEqual({method.name for method in own.service[0].method}, names)

    def test_one_stream_has_several_questions(self):
        client = self.client(self.serve())
        asked, answered = self.messages(client, "v1")
        questions = [asked(file_containing_symbol="grpc.health.v1.Health.Watch"), asked(file_by_filename="inference.proto"),
                     asked(all_extension_numbers_of_type="inference.ModelInferRequest"), asked(file_containing_symbol="no.such.Type"),
                     asked(file_by_filename="no.proto"), asked(file_containing_extension={"containing_type": "a", "extension_number": 1})]
        responses = [answered.FromString(response) for response in self.ask(client, "v1", *(q.SerializeToString() for q in questions))]
        self.assertEqual([response.original_request for response in responses], questions)
        files = [descriptor_pb2.FileDescriptorProto.FromString(a.file_descriptor_response.file_descriptor_proto[0]).name for a in responses[:2]]
        self.assertEqual(files, ["grpc/health/v1/health.proto", "inference.proto"])
        self.assertEqual(responses[2].all_extension_numbers_response.base_type_name, "inference.ModelInferRequest")
        not_found = grpc.StatusCode.NOT_FOUND.value[0]
        self.assertEqual([(a.error_response.error_code, a.error_response.error_message) for a in responses[3:]],
                         [(not_found, "there is no symbol no.such.Type here"), (not_found, "there is no file no.proto here"),
                          (not_found, "there are no extensions here")])

    def test_damaged_and_long_questions_end_the_stream(self):
        client = self.client(self.serve())
        for question in (b"", b"\x3a\xff", b"\x22\x81\x08" + b"a" * 1025, b"\x0a\x00" * 3000):
            code, text = status_of(lambda: self.ask(client, "v1", question))
            self.assertEqual(code, "INVALID_ARGUMENT", question)
            self.assertIn("a damaged ServerReflectionRequest", text)


if __name__ == "__main__":
    tap_runner.main()
