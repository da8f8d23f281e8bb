#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tensor_sink_grpc and tensor_src_grpc with Python's grpcio at the other end, as client and as server.

The messages are those of protoc's and flatc's classes, the bytes NumPy's.
"""

import concurrent.futures
import os
import pathlib
import queue
import socket
import tempfile
import threading
import unittest

import grpc
import numpy as np

import tap_runner
from served_pipeline import Pipeline, status_of
from tensor_messages import TYPES, Flatbuf, Message, Protobuf

SECONDS = 240  # ends what hangs
SCHEMAS = {"protobuf": Protobuf, "flatbuf": Flatbuf}
# The bytes of an empty message: google.protobuf.Empty, and an empty table as flatc's classes write it.
EMPTY = {"protobuf": b""}
OPTIONS = [("grpc.enable_http_proxy", 0), ("grpc.use_local_subchannel_pool", 1),
           ("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]


def empty_table():
    import flatbuffers
    builder = flatbuffers.Builder(0)
    builder.StartObject(0)
    builder.Finish(builder.EndObject())
    return bytes(builder.Output())


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Client:
    """Calls a server of TensorService; messages are bytes."""

    def __init__(self, port, schema):
        self.channel = grpc.insecure_channel(f"127.0.0.1:{port}", OPTIONS)
        service = f"/nnstreamer.{schema}.TensorService/"
        self.send = self.channel.stream_unary(service + "SendTensors")
        self.receive = self.channel.unary_stream(service + "RecvTensors")
        self.close = self.channel.close


class Server(grpc.GenericRpcHandler):
    """Keeps what clients send, and sends `messages` to each client that asks."""

    def __init__(self, schema, messages=(), port=0):
        self.path, self.schema, self.messages = f"/nnstreamer.{schema}.TensorService/", schema, messages
        self.got, self.requests = queue.Queue(), []
        self.server = grpc.server(concurrent.futures.ThreadPoolExecutor(4), (self,), options=OPTIONS + [("grpc.so_reuseport", 0)])
        self.port = self.server.add_insecure_port(f"127.0.0.1:{port}")
        self.server.start()

    def service(self, handler_call_details):
        return {self.path + "SendTensors": grpc.stream_unary_rpc_method_handler(self.take),
                self.path + "RecvTensors": grpc.unary_stream_rpc_method_handler(self.give)}.get(handler_call_details.method)

    def take(self, messages, _):
        for message in messages:
            self.got.put(message)
        return EMPTY[self.schema]

    def give(self, request, _):
        self.requests.append(request)
        yield from self.messages

    def stop(self):
        self.server.stop(0).wait()


class GrpcElements(unittest.TestCase):
    libraries = {}
    classes = tempfile.TemporaryDirectory()

    @classmethod
    def setUpClass(cls):
        EMPTY["flatbuf"] = empty_table()
        for name, make in SCHEMAS.items():
            cls.libraries[name] = make(pathlib.Path(cls.classes.name))

    def setUp(self):
        self.random = np.random.default_rng(1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def play(self, text, ports=1):
        pipeline = Pipeline(text, ports)
        self.addCleanup(pipeline.stop)
        self.assertTrue(pipeline.port, "".join(pipeline.lines))
        return pipeline

    def client(self, port, schema):
        client = Client(port, schema)
        self.addCleanup(client.close)
        return client

    def array(self, dtype="float32", shape=(2, 3)):
        return self.random.integers(0, 100, shape).astype(dtype)

    def source(self, schema, rest="", options=""):
        self.out = self.folder / "out"
        return self.play(f"tensor_src_grpc port=0 idl={schema} {options} ! {rest} filesink buffer-mode=unbuffered location={self.out}")

    def sink_text(self, arrays, options, frames_text=""):
        path = self.folder / "frames"
        path.write_bytes(b"".join(a.tobytes() for a in arrays))
        shape = ":".join(str(n) for n in reversed(arrays[0].shape))
        return (f"filesrc location={path} blocksize={arrays[0].nbytes} ! application/octet-stream,framerate=10/1 ! "
                f"tensor_converter input-dim={shape} input-type={arrays[0].dtype} ! {frames_text} tensor_sink_grpc sync=false {options}")

    def wait_for_bytes(self, count):
        deadline = threading.Event()
        for _ in range(SECONDS * 100):
            if self.out.exists() and self.out.stat().st_size >= count:
                return self.out.read_bytes()
            deadline.wait(0.01)
        self.fail(f"{self.out.stat().st_size} bytes came, {count} are missing")

    def serve(self, schema, messages=(), port=0):
        server = Server(schema, messages, port)
        self.addCleanup(server.stop)
        return server

    def test_a_client_sends_every_type(self):
        for schema, library in self.libraries.items():
            for dtype in TYPES:
                with self.subTest(schema, dtype=dtype):
                    pipeline = self.source(schema)
                    arrays = [self.array(dtype) for _ in range(3)]
                    response = self.client(pipeline.port, schema).send(iter([library.write(Message([a])) for a in arrays]), timeout=SECONDS)
                    self.assertEqual(response, EMPTY[schema])
                    self.assertEqual(self.wait_for_bytes(3 * arrays[0].nbytes), b"".join(a.tobytes() for a in arrays))
                    self.assertIn(f"types=(string){dtype}, framerate=(fraction)10/1", pipeline.stop())

    def test_many_tensors_pass_through_both_elements(self):
        """More than there are memories in a buffer; read by the library after both."""
        for schema, library in self.libraries.items():
            with self.subTest(schema):
                server = self.serve(schema)
                arrays = [self.array("uint8", (i % 5 + 1,)) for i in range(40)]
                pipeline = self.play(f"tensor_src_grpc port=0 idl={schema} ! tensor_sink_grpc port={server.port} idl={schema} name=sink")
                port = int(pipeline.found(r"SrcGrpc:\w+: port = (\d+)")[0])
                self.client(port, schema).send(iter([library.write(Message(arrays))]), timeout=SECONDS)
                self.assertEqual(library.read(server.got.get(timeout=SECONDS)), Message(arrays))

    def test_a_client_receives_the_frames_and_their_end(self):
        for schema, library in self.libraries.items():
            with self.subTest(schema):
                arrays = [self.array() for _ in range(5)]
                pipeline = self.play(self.sink_text(arrays, f"server=true port=0 idl={schema}"))
                messages = list(self.client(pipeline.port, schema).receive(EMPTY[schema], timeout=SECONDS))
                self.assertEqual([library.read(m) for m in messages], [Message([a]) for a in arrays])
                self.assertNotIn("ERROR", pipeline.stop())

    def test_a_server_takes_the_frames(self):
        for schema, library in self.libraries.items():
            with self.subTest(schema):
                server = self.serve(schema)
                arrays = [self.array("int16", (4, 2, 3)) for _ in range(5)]
                output = Pipeline(self.sink_text(arrays, f"port={server.port} idl={schema}"), 0).stop_at_end()
                self.assertNotIn("ERROR", output)
                self.assertEqual([library.read(server.got.get(timeout=SECONDS)) for _ in arrays], [Message([a]) for a in arrays])

    def test_a_server_gives_the_frames(self):
        for schema, library in self.libraries.items():
            with self.subTest(schema):
                arrays = [self.array() for _ in range(5)]
                server = self.serve(schema, [library.write(Message([a])) for a in arrays])
                out = self.folder / "out"
                output = Pipeline(f"tensor_src_grpc server=false idl={schema} port={server.port} ! filesink location={out}", 0).stop_at_end()
                self.assertNotIn("ERROR", output)
                self.assertEqual(out.read_bytes(), b"".join(a.tobytes() for a in arrays))
                self.assertEqual(server.requests, [EMPTY[schema]])

    def test_messages_that_cannot_be_used_end_their_call_alone(self):
        for schema, library in self.libraries.items():
            pipeline = self.source(schema, options="max-message=100000")
            good = self.array()
            whole = library.write(Message([good]))
            wrong_type, too_small = Message([good]), Message([good])
            wrong_type.tensors = [(77, *wrong_type.tensors[0][1:])]
            too_small.tensors = [(*too_small.tensors[0][:2], too_small.tensors[0][2][:-1])]
            cases = {"truncated": (whole[:-5], "INVALID_ARGUMENT", f"a {schema} message is damaged"),
                     "no message": (b"\xff" * 50, "INVALID_ARGUMENT", f"a {schema} message is damaged"),
                     "empty": (b"", "INVALID_ARGUMENT", f"a {schema} message is damaged"),
                     "count": (library.write(Message([good], declared=3)), "INVALID_ARGUMENT", "the number of tensors that it declares"),
                     "no tensors": (library.write(Message([])), "INVALID_ARGUMENT", "at least 1"),
                     "type": (library.write(wrong_type), "INVALID_ARGUMENT", "offered: type 77"),
                     "size": (library.write(too_small), "INVALID_ARGUMENT", "offered: 23 bytes"),
                     "flexible": (library.write(Message([good], fmt=1)), "INVALID_ARGUMENT", "the message holds flexible tensors"),
                     "sparse": (library.write(Message([good], fmt=2)), "INVALID_ARGUMENT", "sparse tensors"),
                     "too large": (library.write(Message([self.array("uint8", (100001,))])), "RESOURCE_EXHAUSTED", "larger than max")}
            for name, (message, status, words) in cases.items():
                with self.subTest(schema, case=name):
                    waits = threading.Event()
                    self.addCleanup(waits.set)

                    def messages(message=message, waits=waits):
                        yield message
                        waits.wait(SECONDS)  # the call is ended by the server
                    got, text = status_of(lambda: self.client(pipeline.port, schema).send(messages(), timeout=SECONDS))
                    waits.set()
                    self.assertEqual(got, status, text)
                    self.assertIn(words, text)
            self.client(pipeline.port, schema).send(iter([whole]), timeout=SECONDS)
            self.assertEqual(self.wait_for_bytes(good.nbytes), good.tobytes())
            output = pipeline.stop()
            self.assertNotIn("CRITICAL", output)
            self.assertNotIn("ERROR", output)

    def test_a_server_with_damaged_messages_is_an_error(self):
        server = self.serve("protobuf", [b"\xff" * 9])
        output = Pipeline(f"tensor_src_grpc server=false port={server.port} ! fakesink async=false", 0).stop_at_end()
        self.assertIn(f"WEIR-2005: a message of localhost:{server.port} was refused: a protobuf message is damaged", output)

    def test_a_server_without_the_service_is_an_error(self):
        server = self.serve("flatbuf")
        output = Pipeline(f"tensor_src_grpc server=false idl=protobuf port={server.port} ! fakesink async=false", 0).stop_at_end()
        self.assertIn(f"WEIR-6002: the server localhost:{server.port} refused the call", output)
        self.assertIn("offered: /nnstreamer.protobuf.TensorService/RecvTensors", output)

    def test_a_client_that_does_not_read_stops_no_other(self):
        arrays = [self.array("uint8", (400_000,)) for _ in range(100)]
        pipeline = self.play(self.sink_text(arrays, "server=true port=0 queue=2 name=sink", "identity sleep-time=1000 !"))
        still = self.client(pipeline.port, "protobuf").receive(b"", timeout=SECONDS)
        messages = sum(1 for _ in self.client(pipeline.port, "protobuf").receive(b"", timeout=SECONDS))
        self.assertGreater(messages, 75)
        still.cancel()

    def test_bytes_that_are_not_http_are_survived(self):
        pipeline = self.source("protobuf")
        for data in (b"", b"GET / HTTP/1.1\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\xff" * 200, os.urandom(5000)):
            with socket.create_connection(("127.0.0.1", pipeline.port)) as one:
                one.sendall(data)
        good = self.array()
        self.client(pipeline.port, "protobuf").send(iter([self.libraries["protobuf"].write(Message([good]))]), timeout=SECONDS)
        self.assertEqual(self.wait_for_bytes(good.nbytes), good.tobytes())

    def test_a_killed_sender_ends_its_call_alone(self):
        pipeline = self.source("protobuf")
        sender = Pipeline(f"videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! "
                          f"tensor_sink_grpc port={pipeline.port}", 0)
        self.wait_for_bytes(16 * 3)
        sender.process.kill()
        sender.stop()
        size = self.out.stat().st_size
        good = self.array("uint8", (4, 4))
        self.client(pipeline.port, "protobuf").send(iter([self.libraries["protobuf"].write(Message([good]))]), timeout=SECONDS)
        self.assertEqual(self.wait_for_bytes(size + 16)[-16:], good.tobytes())

    def test_a_sender_finds_its_server_again(self):
        port = free_port()
        first = Pipeline(f"tensor_src_grpc port={port} ! fakesink", 0)
        sender = Pipeline("videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! "
                          f"tensor_sink_grpc port={port}", 0)
        self.addCleanup(sender.stop)
        self.assertTrue(first.wait_for("(dimensions=.string.1:4:4:1)"))
        first.process.kill()
        first.stop()
        second = Pipeline(f"tensor_src_grpc port={port} ! fakesink", 0)
        self.addCleanup(second.stop)
        self.assertTrue(second.wait_for("(dimensions=.string.1:4:4:1)"))
        self.assertNotIn("ERROR", sender.stop())

    def test_a_receiver_finds_its_server_again(self):
        message = self.libraries["flatbuf"].write(Message([self.array("uint8", (4,))]))
        port, ends = free_port(), threading.Event()
        self.addCleanup(ends.set)

        def endless():
            yield message
            ends.wait(SECONDS)
        first = Server("flatbuf", endless(), port)
        out = self.folder / "out"
        pipeline = Pipeline(f"tensor_src_grpc server=false idl=flatbuf port={port} num-buffers=2 ! filesink buffer-mode=unbuffered location={out}", 0)
        self.out = out
        self.wait_for_bytes(4)
        first.stop()  # cancels the call: its generator would end the stream
        ends.set()
        self.serve("flatbuf", [message], port)
        pipeline.stop_at_end()
        self.assertEqual(out.stat().st_size, 8)


if __name__ == "__main__":
    tap_runner.main()
