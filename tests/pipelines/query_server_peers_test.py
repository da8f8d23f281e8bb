#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Peers that stall, flood, cancel, close half of a connection or send bombs: a server serves others meanwhile and afterwards."""

import concurrent.futures
import pathlib
import re
import socket
import struct
import tempfile
import time
import unittest
import zlib

import grpc
import numpy as np

import http2_peer
import tap_runner
from served_pipeline import Client, Gate, Pipeline, ends_behind_gate, request, status_of

FLOATS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"
INFER = "/inference.GRPCInferenceService/ModelInfer"
LIVE = "/inference.GRPCInferenceService/ServerLive"
TRACE = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
X = np.array([[1.5, -2, 0, 1e6]], np.float32)
MIB = 1 << 20


class Peers(unittest.TestCase):
    def serve(self, options="port=0", between="", caps=FLOATS, ports=1, gate=None):
        pipeline = Pipeline(f"tensor_query_serversrc name=server protocol=oip model-name=same {options} {caps} ! {between} "
                            "tensor_query_serversink", ports, gate)
        self.addCleanup(pipeline.stop)
        return pipeline

    def client(self, pipeline, address=None, ready=True):
        client = Client(address or f"127.0.0.1:{pipeline.port}")
        self.addCleanup(client.close)
        if ready:
            client.wait_until_ready("same")
        return client

    def peer(self, pipeline):
        peer = http2_peer.Connection(pipeline.port)
        self.addCleanup(peer.close)
        return peer

    def socket(self, pipeline):
        out = socket.create_connection(("127.0.0.1", pipeline.port), 10)
        self.addCleanup(out.close)
        return out

    def status(self, pipeline, field):
        text = pathlib.Path(f"/proc/{pipeline.process.pid}/status").read_text()
        return int(re.search(rf"{field}:\s+(\d+)", text)[1])

    def descriptors(self, pipeline):
        return len(list(pathlib.Path(f"/proc/{pipeline.process.pid}/fd").iterdir()))

    def serves(self, client):
        self.assertEqual(client.infer(request("same", X)).raw_output_contents[0], X.tobytes())

    def descriptors_fall_to(self, pipeline, most):
        end = time.monotonic() + 30
        while self.descriptors(pipeline) > most and time.monotonic() < end:
            socket.create_connection(("127.0.0.1", pipeline.port), 10).close()  # something for the server to do
        self.assertLessEqual(self.descriptors(pipeline), most)

    def ended(self, pipeline):
        pipeline.stop()
        counts = pipeline.wait_for(r"requests: (\d+) received = (\d+) answered \+ (\d+) refused \+ (\d+) expired \+ (\d+) aborted")
        self.assertEqual(len(counts), 1, "".join(pipeline.lines))
        received, *ends = map(int, counts[0])
        self.assertEqual(received, sum(ends))
        return received, ends


class Addresses(Peers):
    def test_a_unix_socket_is_served(self):
        with tempfile.TemporaryDirectory() as folder:
            pipeline = self.serve(f"unix-path={folder}/served", ports=0)
            client = self.client(pipeline, f"unix:{folder}/served")
            self.serves(client)
            calls = [client.stub.ModelInfer.future(request("same", X), timeout=30) for _ in range(20)]
            self.assertEqual({status_of(call.result)[0] for call in calls}, {"OK"})
            self.assertEqual(self.ended(pipeline)[1], [21, 0, 0, 0])

    def test_a_unix_socket_that_cannot_be_made_is_an_error(self):
        text = Pipeline(f"tensor_query_serversrc protocol=oip unix-path=/nowhere/served {FLOATS} ! tensor_query_serversink").stop()
        self.assertIn("WEIR-1004: the server cannot listen on this address\n  offered: unix:/nowhere/served", text)
        self.assertNotIn("port=0", text)

    def test_there_are_no_more_connections_with_requests_than_allowed(self):
        gate = Gate(self)
        pipeline = self.serve("port=0 max-connections=2 max-connections-per-address=0", gate.text, gate=gate)
        # A call of the others could still have a place, although it has its response.
        clients = [self.client(pipeline), *(self.client(pipeline, ready=False) for _ in range(3))]
        ended = ends_behind_gate(pipeline, gate, clients, request("same", X), refused=2)
        self.assertEqual(sorted(code for code, _ in ended), ["OK"] * 2 + ["RESOURCE_EXHAUSTED"] * 2)
        self.assertIn("the server serves 2 connections at a time (max-connections)", [text for code, text in ended if code != "OK"])


class Bombs(Peers):
    def test_a_compressed_request_is_refused(self):
        client = self.client(self.serve())
        for compression in (grpc.Compression.Gzip, grpc.Compression.Deflate):
            code, text = status_of(lambda: client.stub.ModelInfer(request("same", X), timeout=30, compression=compression))
            self.assertEqual(code, "UNIMPLEMENTED", text)
            self.assertRegex(text, "(?i)compress")
        self.serves(client)

    def test_a_gigabyte_of_zeros_is_not_unpacked(self):
        pack = zlib.compressobj(9, wbits=31)
        bomb = b"".join(pack.compress(bytes(MIB)) for _ in range(1024)) + pack.flush()
        self.assertLess(len(bomb), 2 * MIB)
        pipeline = self.serve(f"port=0 max-message={1 << 30}")
        client = self.client(pipeline)
        self.serves(client)
        before = self.status(pipeline, "VmHWM")
        peer = self.peer(pipeline)
        stream = peer.call(INFER, bomb, more=[("grpc-encoding", "gzip")], compressed=True)
        end = time.monotonic() + 30
        while stream.reset is None and not peer.closed and time.monotonic() < end:
            peer.push()
            peer.read(1)
        self.assertTrue(stream.reset is not None or peer.closed)
        self.assertLess(self.status(pipeline, "VmHWM") - before, 32 << 10)
        self.serves(client)
        self.assertEqual(self.ended(pipeline), (2, [2, 0, 0, 0]))


class Texts(Peers):
    """gRPC aborts a process that sends a header with other bytes than printable ASCII."""

    def called(self, peer, path, message=b"", more=()):
        stream = peer.call(path, message, more=more)
        end = time.monotonic() + 30
        while stream.reset is None and not peer.closed and time.monotonic() < end:
            peer.push()
            peer.read(1)
        self.assertIsNotNone(stream.reset, "the call has not ended")
        return stream

    def test_a_trace_with_any_bytes_does_not_stop_the_server(self):
        pipeline = self.serve()
        client = self.client(pipeline)
        peer = self.peer(pipeline)
        for path in (LIVE, INFER, "/grpc.health.v1.Health/Check", "/other.Service/Method"):
            for trace in (b"\x80\x80\x80\x80", b"trace\x1f", b"trace\x7f", b"\xff" * 100, b"a\tb", b"hello\n", TRACE.encode()[:-1] + b"\xe9"):
                stream = self.called(peer, path, more=[("traceparent", trace)])
                self.assertNotIn(trace, stream.headers)
        self.assertIn(TRACE.encode(), self.called(peer, LIVE, more=[("traceparent", TRACE)]).headers)
        self.serves(client)

    def test_only_the_trace_of_a_request_comes_back(self):
        client = self.client(self.serve())
        for trace in (TRACE, TRACE.upper(), TRACE + "-", TRACE.replace("-", "_"), "hello", " "):
            _, call = client.stub.ModelInfer.with_call(request("same", X), timeout=30, metadata=[("traceparent", trace)])
            self.assertEqual([value for name, value in call.trailing_metadata() if name == "traceparent"], [TRACE] * (trace == TRACE), trace)

    def test_errors_with_any_bytes_are_sent(self):
        """Names of a client come back in the texts of errors."""
        pipeline = self.serve()
        peer = self.peer(pipeline)
        names = [bytes(range(first, first + 16)) for first in range(0, 256, 16)]
        for name in names:
            text = "".join(chr(byte) if 32 <= byte < 127 and byte != 37 else f"%{byte:02X}" for byte in name)
            for path in (INFER, "/inference.GRPCInferenceService/ModelReady", "/grpc.health.v1.Health/Check"):
                self.assertIn(text.encode(), self.called(peer, path, b"\x0a\x10" + name).headers, path)
        self.serves(self.client(pipeline))


class Stalls(Peers):
    def test_others_are_served_while_a_peer_does_not_read_its_answers(self):
        large = "caps=other/tensor,dimension=(string)1048576,type=(string)uint8,framerate=0/1"
        pipeline = self.serve("port=0 max-connections-per-address=0", caps=large)
        client = self.client(pipeline)
        x = np.arange(MIB, dtype=np.uint32).astype(np.uint8)
        message = request("same", x, "UINT8")
        client.infer(message)
        before = self.status(pipeline, "VmRSS")
        peers = [self.peer(pipeline) for _ in range(4)]
        streams = [peer.call(INFER, message.SerializeToString()) for peer in peers for _ in range(4)]
        end = time.monotonic() + 60
        while any(stream.unsent for stream in streams) and time.monotonic() < end:
            for peer in peers:
                peer.push()
                peer.read(0.005)  # room for requests; what comes of responses is never acknowledged
        self.assertFalse(any(stream.unsent for stream in streams))
        for _ in range(20):
            self.assertEqual(client.infer(message).raw_output_contents[0], x.tobytes())
        self.assertEqual([stream.reset for stream in streams], [None] * 16)
        self.assertLess(self.status(pipeline, "VmRSS") - before, (2 * 16 + 32) << 10)
        for peer in peers:
            peer.close()
        client.infer(message)
        self.assertEqual(self.ended(pipeline)[0], 38)

    def test_a_flood_of_connections_leaves_nothing_behind(self):
        pipeline = self.serve()
        client = self.client(pipeline)
        self.serves(client)
        before = self.descriptors(pipeline)
        flood = [self.socket(pipeline) for _ in range(300)]
        for i, each in enumerate(flood):
            try:
                each.sendall([b"", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01\xff\xff"][i % 4])
            except OSError:
                pass  # it was closed before
        for _ in range(20):
            self.serves(client)
        for each in flood:
            each.close()
        self.descriptors_fall_to(pipeline, before + 4)
        self.serves(client)

    def test_half_open_connections_leave_nothing_behind(self):
        pipeline = self.serve()
        client = self.client(pipeline)
        self.serves(client)
        before = self.descriptors(pipeline)
        for end in ("half", "reset", "vanish") * 10:
            peer = http2_peer.Connection(pipeline.port)
            peer.call(INFER, bytes(100), announced=1000)
            peer.push()
            self.assertTrue(peer.ping())
            if end == "half":
                peer.socket.shutdown(socket.SHUT_WR)
                while not peer.closed:
                    peer.read(10)
            elif end == "reset":
                peer.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            peer.close()
            self.serves(client)
        self.descriptors_fall_to(pipeline, before + 4)

    def test_a_client_that_vanishes_gives_back_its_place(self):
        """The server knows after 20 seconds, and keeps the other client, which makes no call meanwhile."""
        pipeline = self.serve("port=0 max-connections=1")
        peer = self.peer(pipeline)
        stream = peer.call(INFER, bytes(100), announced=1000)
        peer.push()
        self.assertTrue(peer.ping())
        client = Client(f"127.0.0.1:{pipeline.port}")
        self.addCleanup(client.close)
        self.assertEqual(status_of(lambda: client.infer(request("same", X)))[0], "RESOURCE_EXHAUSTED")
        peer.socket.settimeout(60)
        while peer.socket.recv(1 << 16):  # reads the ping and does not answer it
            pass
        end = time.monotonic() + 30
        while (code := status_of(lambda: client.infer(request("same", X)))[0]) == "RESOURCE_EXHAUSTED":
            self.assertLess(time.monotonic(), end)
        self.assertEqual((code, stream.reset), ("OK", None))

    def test_pings_of_clients_are_accepted(self):
        peer = self.peer(self.serve())
        stream = peer.call("/grpc.health.v1.Health/Watch")
        peer.push()
        self.assertTrue(peer.ping())
        end = time.monotonic() + 3
        while time.monotonic() < end:
            peer.read(0.15)  # a client may send a ping each 100 ms
            if not peer.ping():
                break
        self.assertEqual((peer.closed, peer.goodbye, stream.reset), (False, None, None))

    def test_cancel_storms_end_every_request(self):
        pipeline = self.serve("port=0 max-requests=0 max-connections-per-address=0 queue=2000", "queue !")

        def storm(number):
            client = Client(f"127.0.0.1:{pipeline.port}")
            calls = [client.stub.ModelInfer.future(request("same", X), timeout=30) for _ in range(200)]
            for i, call in enumerate(calls):
                if (i + number) % 4:
                    call.cancel()
            codes = []
            for call in calls:
                try:
                    codes.append(status_of(call.result)[0])
                except grpc.FutureCancelledError:
                    codes.append("CANCELLED")
            client.close()
            return codes

        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            codes = sum(pool.map(storm, range(8)), [])
        self.assertLessEqual(set(codes), {"OK", "CANCELLED"})
        self.assertEqual(len(codes), 1600)
        self.assertGreaterEqual(codes.count("OK"), 400)
        self.serves(self.client(pipeline))
        received, ends = self.ended(pipeline)
        self.assertGreaterEqual(ends[0], 401)
        self.assertLessEqual(received, 1601)


if __name__ == "__main__":
    tap_runner.main()
