#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What one peer may take of a server: requests, connections, bytes, memory. Hostile peers speak HTTP/2 themselves."""

import pathlib
import re
import tempfile
import time
import unittest

import numpy as np

import http2_peer
import tap_runner
from built_modules import has_engine
from served_pipeline import Client, Gate, Pipeline, ends_behind_gate, request, status_of

FLOATS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"
INFER = "/inference.GRPCInferenceService/ModelInfer"
X = np.array([[1.5, -2, 0, 1e6]], np.float32)
MIB = 1 << 20


class Served(unittest.TestCase):
    def serve(self, options="", between="", caps=FLOATS, gate=None):
        pipeline = Pipeline(f"tensor_query_serversrc protocol=oip port=0 model-name=same {options} {caps} ! {between} tensor_query_serversink",
                            gate=gate)
        self.addCleanup(pipeline.stop)
        self.assertTrue(pipeline.port, "".join(pipeline.lines))
        return pipeline

    def client(self, pipeline, ready=True):
        client = Client(f"127.0.0.1:{pipeline.port}")
        self.addCleanup(client.close)
        if ready:
            client.wait_until_ready("same")
        return client


def ends(peer, stream):
    """Whether the server ends a stream."""
    end = time.monotonic() + 60
    while stream.reset is None and not peer.closed and time.monotonic() < end:
        peer.push()
        peer.read(1)
    return stream.reset is not None


class Limits(Served):
    @unittest.skipUnless(has_engine("python3"), "the engine python3 is not built")
    def test_a_request_that_expires_in_the_queue_of_the_filter_is_not_invoked(self):
        """Two workers have a frame each until the file `end` is there; the others wait for them, and their clients only 1 s."""
        with tempfile.TemporaryDirectory() as folder:
            script, end = pathlib.Path(folder) / "slow.py", pathlib.Path(folder) / "end"
            script.write_text("import os, sys, time\n\n\nclass CustomFilter:\n    def setInputDim(self, dims):\n        return dims\n\n"
                              "    def invoke(self, arrays):\n        print('invoked', file=sys.stderr, flush=True)\n"
                              f"        while not os.path.exists('{end}'):\n            time.sleep(0.01)\n"
                              "        return [array.copy() for array in arrays]\n")
            pipeline = self.serve(between=f"tensor_filter framework=python3 model={script} workers=2 !")
            client = self.client(pipeline)
            first = [client.stub.ModelInfer.future(request("same", X), timeout=60) for _ in range(2)]
            self.assertEqual(len(pipeline.wait_for("invoked", 2)), 2)
            peer = self.peer(pipeline)
            late = [peer.call(INFER, request("same", X).SerializeToString(), more=[("grpc-timeout", "1S")]) for _ in range(4)]
            for stream in late:
                self.assertTrue(ends(peer, stream))
            end.touch()
            self.assertEqual([status_of(call.result)[0] for call in first], ["OK"] * 2)
            self.assertEqual(status_of(lambda: client.infer(request("same", X)))[0], "OK")
            pipeline.stop()
        self.assertEqual(len(pipeline.found("invoked")), 3)

    def peer(self, pipeline):
        peer = http2_peer.Connection(pipeline.port)
        self.addCleanup(peer.close)
        return peer

    def resident(self, pipeline):
        status = pathlib.Path(f"/proc/{pipeline.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) << 10

    def flood(self, pipeline, calls, size, whole):
        """Four connections whose calls send all but the last byte of a message; `whole` of them get the room to do so."""
        peers = [self.peer(pipeline) for _ in range(4)]
        for peer in peers:
            for _ in range(calls):
                peer.call(INFER, bytes(size - 1), announced=size)
        streams = [stream for peer in peers for stream in peer.streams.values()]
        end, quiet = time.monotonic() + 60, 0
        while quiet < 50 and time.monotonic() < end:
            unsent = sum(len(stream.unsent) for stream in streams)
            for peer in peers:
                peer.push()
                peer.read(0.005)
            is_still = unsent == sum(len(stream.unsent) for stream in streams)
            quiet = quiet + 1 if is_still and sum(not stream.unsent for stream in streams) >= whole else 0
        self.assertEqual([peer.closed for peer in peers], [False] * 4)
        return peers, streams

    def test_stalled_messages_take_no_more_memory_than_one_address_may(self):
        pipeline = self.serve(f"max-message={4 * MIB} max-bytes-in-flight={16 * MIB}")
        client = self.client(pipeline)
        client.infer(request("same", X))
        before = self.resident(pipeline)
        peers, streams = self.flood(pipeline, 8, 4 * MIB, 4)
        self.assertEqual(sum(not stream.unsent for stream in streams), 4)
        self.assertEqual([stream.reset for stream in streams], [None] * 32)
        self.assertLess(self.resident(pipeline) - before, (16 + 32) * MIB)
        for peer in peers:
            peer.close()
        end = time.monotonic() + 60
        while (response := status_of(lambda: client.infer(request("same", X))))[0] == "RESOURCE_EXHAUSTED":  # until it has seen the closes
            self.assertLess(time.monotonic(), end)
        self.assertEqual(response[1].raw_output_contents[0], X.tobytes())

    def test_without_the_limit_they_take_all_that_they_send(self):
        """What the test above would find if the limit did nothing."""
        pipeline = self.serve(f"max-message={4 * MIB} max-bytes-in-flight=0")
        before = self.resident(pipeline)
        _, streams = self.flood(pipeline, 8, 4 * MIB, 32)
        self.assertEqual(sum(not stream.unsent for stream in streams), 32)
        self.assertGreater(self.resident(pipeline) - before, 64 * MIB)

    def test_calls_wait_for_the_room_of_their_address_until_others_end(self):
        pipeline = self.serve(f"max-message={MIB} max-bytes-in-flight={MIB}")
        stalled = self.peer(pipeline)
        stalled.call(INFER, b"", announced=MIB)
        stalled.push()
        self.assertTrue(stalled.ping())
        # It ends at the server: a client may end it before, and its request would come when there is room.
        waits = self.peer(pipeline)
        stream = waits.call(INFER, request("same", X).SerializeToString(), more=[("grpc-timeout", "500m")])
        self.assertTrue(ends(waits, stream))
        self.assertNotIn(b"max-bytes-in-flight", stream.headers)
        client = self.client(pipeline, ready=False)
        call = client.stub.ModelInfer.future(request("same", X), timeout=60)
        stalled.close()
        self.assertEqual(status_of(call.result)[0], "OK")

    def test_an_address_has_no_more_connections_with_requests_than_allowed(self):
        gate = Gate(self)
        pipeline = self.serve("", gate.text, gate=gate)
        # A call of the others could still have a place, although it has its response.
        clients = [self.client(pipeline), *(self.client(pipeline, ready=False) for _ in range(5))]
        ended = ends_behind_gate(pipeline, gate, clients, request("same", X), refused=2)
        self.assertEqual(sorted(code for code, _ in ended), ["OK"] * 4 + ["RESOURCE_EXHAUSTED"] * 2)
        self.assertIn("this address has 4 connections with requests in progress (max-connections-per-address)",
                      [text for code, text in ended if code != "OK"])

    def test_an_idle_connection_is_closed_and_a_busy_one_is_not(self):
        pipeline = self.serve("idle-timeout=1000", "identity sleep-time=2500000 !")
        client = self.client(pipeline)
        idle = self.peer(pipeline)
        call = client.stub.ModelInfer.future(request("same", X), timeout=30)
        end = time.monotonic() + 60
        while not idle.closed and time.monotonic() < end:
            idle.read(1)
        self.assertTrue(idle.closed)
        self.assertIsNotNone(idle.goodbye)
        self.assertEqual(status_of(call.result)[0], "OK")

    def test_calls_one_after_the_other_keep_their_connection(self):
        pipeline = self.serve()
        peer = self.peer(pipeline)
        for _ in range(20):
            stream = peer.call("/inference.GRPCInferenceService/ServerLive")
            peer.push()
            while stream.reset is None and not peer.closed:
                peer.read(10)
        self.assertEqual((peer.closed, peer.goodbye), (False, None))


class Responses(Served):
    """What responses take that their clients do not read."""

    MEBIBYTE = "caps=other/tensor,dimension=(string)1048576:1,type=(string)uint8,framerate=0/1"

    def answered(self, pipeline, message):
        """A peer with a call whose response the server has and cannot send."""
        peer = http2_peer.Connection(pipeline.port, own_window=0)
        self.addCleanup(peer.close)
        end = time.monotonic() + 60
        while True:
            stream = peer.call(INFER, message.SerializeToString())
            while not stream.headers and not peer.closed and time.monotonic() < end:  # they come before the response
                peer.push()
                peer.read(1)
            self.assertTrue(stream.headers)
            if stream.reset is None:
                return peer, stream
            self.assertLess(time.monotonic(), end)  # refused: a call that has its response may still have a place

    def test_their_connections_count(self):
        pipeline = self.serve()
        client = self.client(pipeline)
        message = request("same", X)
        stalled = [self.answered(pipeline, message) for _ in range(4)]
        code, text = status_of(lambda: client.infer(message))
        self.assertEqual((code, text), ("RESOURCE_EXHAUSTED", "this address has 4 connections with requests in progress (max-connections-per-address)"))
        peer, stream = stalled[0]
        peer.open(stream, MIB)
        self.assertTrue(ends(peer, stream))
        end = time.monotonic() + 60
        while (code := status_of(lambda: client.infer(message))[0]) == "RESOURCE_EXHAUSTED":  # until the server knows
            self.assertLess(time.monotonic(), end)
        self.assertEqual(code, "OK")

    def test_their_bytes_count(self):
        x = np.zeros((1, MIB), np.uint8)
        message = request("same", x, "UINT8")
        pipeline = self.serve(f"max-message={2 * MIB} max-bytes-in-flight={3 * MIB}", caps=self.MEBIBYTE)
        client = self.client(pipeline)
        self.assertEqual(status_of(lambda: client.infer(message))[0], "OK")
        peer, stream = self.answered(pipeline, message)
        self.assertEqual(status_of(lambda: client.infer(message, 0.5))[0], "DEADLINE_EXCEEDED")
        call = client.stub.ModelInfer.future(message, timeout=60)
        peer.open(stream, 2 * MIB)
        self.assertTrue(ends(peer, stream))
        self.assertEqual(status_of(call.result)[0], "OK")

    def test_their_calls_end(self):
        pipeline = self.serve("idle-timeout=1000")
        peer, stream = self.answered(pipeline, request("same", X))
        other = peer.call(INFER, bytes(10), announced=100)  # without it the connection would be idle
        peer.push()
        self.assertTrue(ends(peer, stream))
        self.assertEqual((peer.ping(), other.reset), (True, None))
        client = self.client(pipeline)
        self.assertEqual(status_of(lambda: client.infer(request("same", X)))[0], "OK")

    def test_a_client_that_reads_its_answers_is_never_refused(self):
        client = self.client(self.serve(f"max-requests=1 max-connections=1 max-message={MIB} max-bytes-in-flight={MIB}"))
        codes = [status_of(lambda: client.infer(request("same", X)))[0] for _ in range(300)]
        self.assertEqual(set(codes), {"OK"})


if __name__ == "__main__":
    tap_runner.main()
