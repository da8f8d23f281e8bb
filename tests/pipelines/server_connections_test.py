#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What connections may cost the servers of gRPC: descriptors, memory, time. For tensor_query_serversrc protocol=oip and tensor_src_grpc."""

import contextlib
import os
import pathlib
import re
import resource
import socket
import struct
import tempfile
import time
import unittest
import unittest.mock

import numpy as np

import http2_peer
import tap_runner
from served_pipeline import Client, Pipeline, request, status_of

INFER = "/inference.GRPCInferenceService/ModelInfer"
RECEIVE = "/nnstreamer.protobuf.TensorService/RecvTensors"
X = np.array([[1.5, -2, 0, 1e6]], np.float32)
MIB = 1 << 20
BEFORE_PINGS = 15  # seconds: connections that answer no ping end after 20
CONTINUATION, CANCEL = 9, struct.pack(">I", 8)
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, http2_peer.SETTINGS, 0, 0, 0, 0, 0])
HEADERS = [(":method", "POST"), (":scheme", "http"), (":path", INFER), (":authority", "x"), ("te", "trailers"), ("content-type", "application/grpc")]
CAPS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"


def is_closed(connection):
    """Whether the other side has closed a socket that does not block."""
    try:
        while connection.recv(4096):
            pass
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def frame(kind, flags, number, payload):
    return struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", number) + payload


def wait_until(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


class Connections(unittest.TestCase):
    def setUp(self):
        self.open = contextlib.ExitStack()
        self.addCleanup(self.open.close)

    def serve(self, options="", path=None):
        address = f"unix-path={path}" if path else "port=0"
        pipeline = Pipeline(f"tensor_query_serversrc protocol=oip {address} model-name=same {options} {CAPS} ! tensor_query_serversink",
                            ports=0 if path else 1)
        self.addCleanup(pipeline.stop)
        return pipeline

    def client(self, pipeline, is_ready=True):
        client = Client(f"127.0.0.1:{pipeline.port}")
        self.open.callback(client.close)
        if is_ready:
            client.wait_until_ready("same")
        return client

    def peer(self, pipeline, path=None):
        def connect(*_):
            one = socket.socket(socket.AF_UNIX)
            one.connect(path)
            return one
        with unittest.mock.patch.object(socket, "create_connection", connect) if path else contextlib.nullcontext():
            peer = http2_peer.Connection(None if path else pipeline.port)
        self.open.callback(peer.close)
        return peer

    def idle(self, pipeline, count, address="127.0.0.1"):
        """Connections of HTTP/2 without calls."""
        out = []
        for _ in range(count):
            one = self.open.enter_context(socket.socket())
            one.bind((address, 0))
            one.connect(("127.0.0.1", pipeline.port))
            with contextlib.suppress(OSError):  # the server may have closed it
                one.sendall(PREFACE)
            one.setblocking(False)
            out.append(one)
        return out

    def descriptors(self, pipeline):
        return len(os.listdir(f"/proc/{pipeline.process.pid}/fd"))

    def resident(self, pipeline):
        return int(re.search(r"VmRSS:\s+(\d+) kB", pathlib.Path(f"/proc/{pipeline.process.pid}/status").read_text())[1]) << 10

    def answers(self, pipeline):
        return self.client(pipeline).infer(request("same", X)).raw_output_contents[0] == X.tobytes()

    def answers_again(self, pipeline):
        """An address whose connection cost too much may connect again after ten seconds."""
        client = Client(f"127.0.0.1:{pipeline.port}")
        self.open.callback(client.close)
        return wait_until(lambda: status_of(lambda: client.infer(request("same", X)))[0] == "OK")

    def test_a_server_without_descriptors_accepts_again_when_it_has_some(self):
        for path in (None, os.path.join(self.open.enter_context(tempfile.TemporaryDirectory()), "socket")):
            with self.subTest(path=path):
                pipeline = self.serve(path=path)
                client = Client(f"unix:{path}" if path else f"127.0.0.1:{pipeline.port}")
                self.open.callback(client.close)
                client.wait_until_ready("same")
                limits = resource.prlimit(pipeline.process.pid, resource.RLIMIT_NOFILE)
                full = self.descriptors(pipeline) + 10
                resource.prlimit(pipeline.process.pid, resource.RLIMIT_NOFILE, (full, limits[1]))
                with contextlib.ExitStack() as flood:
                    for _ in range(30):
                        one = flood.enter_context(socket.socket(socket.AF_UNIX if path else socket.AF_INET))
                        one.connect(path or ("127.0.0.1", pipeline.port))
                    self.assertTrue(wait_until(lambda: self.descriptors(pipeline) >= full - 1))
                other = Client(f"unix:{path}" if path else f"127.0.0.1:{pipeline.port}")
                self.open.callback(other.close)
                other.connect()
                self.assertEqual(other.infer(request("same", X)).raw_output_contents[0], X.tobytes())

    def test_an_address_has_32_open_connections(self):
        pipeline = self.serve()
        client = self.client(pipeline)
        idle = self.idle(pipeline, 40, "127.0.0.2")
        self.assertTrue(wait_until(lambda: sum(map(is_closed, idle[32:])) == 8, BEFORE_PINGS))
        self.assertEqual(client.infer(request("same", X)).raw_output_contents[0], X.tobytes())

    def test_of_too_many_connections_those_without_a_call_end(self):
        pipeline = self.serve("max-connections=2")  # 16 may be open
        client = self.client(pipeline)
        idle = [self.idle(pipeline, 1, f"127.0.0.{i}")[0] for i in range(2, 32)]
        self.assertTrue(wait_until(lambda: sum(map(is_closed, idle[:15])) == 15, BEFORE_PINGS))
        self.assertEqual(client.infer(request("same", X)).raw_output_contents[0], X.tobytes())
        self.assertTrue(self.answers(pipeline))

    def test_a_connection_without_a_call_ends(self):
        pipeline = self.serve()
        peer = self.peer(pipeline)
        begun = time.monotonic()
        while not peer.closed and time.monotonic() - begun < 60:
            peer.read(1)
        self.assertTrue(peer.closed)

    def test_connections_leave_no_descriptors_and_no_memory(self):
        pipeline = self.serve("max-connections-per-address=0")
        self.assertTrue(self.answers(pipeline))
        before = self.descriptors(pipeline)
        for i in range(10_000):
            with socket.create_connection(("127.0.0.1", pipeline.port), 60) as one:
                if i % 2:
                    one.sendall(PREFACE)
        self.assertTrue(wait_until(lambda: self.descriptors(pipeline) <= before))
        self.assertTrue(self.answers(pipeline))

    def test_a_connection_that_resets_its_calls_ends(self):
        pipeline = self.serve()
        self.assertTrue(self.answers(pipeline))
        peer, before = self.peer(pipeline), self.resident(pipeline)
        block = http2_peer.header_block(HEADERS)
        with contextlib.suppress(OSError):
            for first in range(1, 80_000, 400):
                peer.socket.sendall(b"".join(frame(http2_peer.HEADERS, http2_peer.END_HEADERS, number, block) +
                                             frame(http2_peer.RST_STREAM, 0, number, CANCEL) for number in range(first, first + 400, 2)))
                peer.read(0)
        self.assertLess(self.resident(pipeline) - before, 128 * MIB)
        self.assertTrue(self.answers_again(pipeline))

    def test_a_connection_whose_headers_never_end_ends(self):
        for known in (False, True):
            with self.subTest(known=known):
                pipeline = self.serve(f"max-message={MIB}")
                peer = self.peer(pipeline)
                if known:
                    peer.call("/grpc.health.v1.Health/Watch", b"")
                    peer.push()
                number = 101
                peer.frame(http2_peer.HEADERS, 0, number, http2_peer.header_block(HEADERS))
                more = http2_peer.header_block([("x-a", "y" * 100)] * 100)
                for _ in range(40_000):
                    peer.frame(CONTINUATION, 0, number, more)
                    if peer.closed:
                        break
                self.assertTrue(peer.closed)
                self.assertTrue(self.answers_again(pipeline))

    def test_calls_whose_message_never_comes_give_back_their_places(self):
        pipeline = self.serve("max-connections=4")
        calls = [(peer, peer.call(INFER)) for peer in [self.peer(pipeline) for _ in range(5)]]

        def refused():
            return [call for call in calls if call[0].read(0) or call[1].reset is not None]
        self.assertTrue(wait_until(refused))  # so that the others have their places
        (_, stream), = refused()
        self.assertIn(b"max-connections", stream.headers)
        client = self.client(pipeline, is_ready=False)  # the connection of a call would count
        self.assertTrue(wait_until(lambda: status_of(lambda: client.infer(request("same", X)))[0] == "OK"))
        for peer, other in calls:
            while other.reset is None and not peer.closed:
                peer.read(1)
        self.assertEqual(sum(b"the message of the call did not come in time" in other.headers for _, other in calls), 4)

    def test_a_message_that_comes_slowly_is_received(self):
        """At three times the rate that is the least: for longer than the time until a message that does not come ends."""
        for path in (None, os.path.join(self.open.enter_context(tempfile.TemporaryDirectory()), "socket")):
            with self.subTest(path=path):
                peer = self.peer(self.serve(path=path), path)
                stream = peer.call(INFER, bytes(10 * MIB))
                begun = time.monotonic()
                unsent, stream.unsent = stream.unsent, memoryview(b"")
                while stream.reset is None and not peer.closed and time.monotonic() - begun < 13:
                    stream.unsent, unsent = unsent[:10_000], unsent[10_000:]
                    peer.push()
                    peer.read(0.5)
                    peer.ping()
                self.assertEqual((stream.reset, peer.closed), (None, False))

    def test_a_receiver_of_tensors_that_does_not_ask_ends(self):
        pipeline = Pipeline("videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! "
                            "tensor_sink_grpc server=true port=0")
        self.addCleanup(pipeline.stop)
        peer = self.peer(pipeline)
        stream = peer.call(RECEIVE)
        begun = time.monotonic()
        while stream.reset is None and not peer.closed and time.monotonic() - begun < 60:
            peer.read(1)
        self.assertIn(b"the request of the call did not come", stream.headers)


if __name__ == "__main__":
    tap_runner.main()
