#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a server offers besides the protocol of models: the health service of gRPC, as Python's grpcio uses it."""

import time
import unittest

import numpy as np

import http2_peer
import tap_runner
from served_pipeline import Client, Pipeline, request, status_of

FLOATS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"
X = np.array([[1.5, -2, 0, 1e6]], np.float32)
WATCH = "/grpc.health.v1.Health/Watch"
SERVING, NOT_SERVING, UNKNOWN = b"\x08\x01", b"\x08\x02", b"\x08\x03"


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
        call = self.watch(self.client(self.serve()), seconds=0.5)
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


if __name__ == "__main__":
    tap_runner.main()
