#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""edgesink and edgesrc in processes of their own: with a Python peer of NNStreamer's protocol, with each other, and when either is killed."""

import json
import os
import signal
import subprocess
import sys

import edge_peer
import tap_runner
from launched_pipelines import SECONDS, LaunchedPipelines
from peer_process import start_peer

CAPS = 'other/tensors,format=static,num_tensors=2,dimensions=(string)"4,3",types=(string)"uint8,uint8",framerate=(fraction)0/1'
FRAMES = [bytes(range(i, i + 8)) for i in (0, 100, 200)]


class Edge(LaunchedPipelines):
    def sink(self, options, frames=b"".join(FRAMES)):
        """An edgesink that sends frames of 8 bytes, and its port."""
        data = self.folder / "frames"
        data.write_bytes(frames)
        process = self.launch(f"filesrc location={data} blocksize=8 ! application/octet-stream ! tensor_converter input-dim=8 "
                              f"input-type=uint8 ! edgesink sync=false wait-connection=true {options}", GST_DEBUG="GST_TRACER:7,edgesink:4")
        return process

    def port_of(self, sink):
        return int(self.wait_for(sink, r"listening on localhost:(\d+)")[1])


class WithThePythonPeer(Edge):
    def subscriber(self, port, frames):
        done = subprocess.run([sys.executable, edge_peer.__file__, "subscriber", "--connect", f"127.0.0.1:{port}", "--frames", str(frames)],
                              capture_output=True, text=True, timeout=SECONDS)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def publisher(self, *options):
        return start_peer(self, sys.executable, edge_peer.__file__, "publisher", *options)

    def test_a_subscriber_reads_each_form(self):
        for version, form in (("0.2.6", 2088), ("0.2.4", 168), ("0.2.2", 160)):
            sink = self.sink(f"port=0 wire-version={version}")
            greeting, *frames = self.subscriber(self.port_of(sink), 3)
            self.assertEqual(greeting["form"], form)
            self.assertTrue(greeting["capability"].startswith("@edge_sink_caps@other/tensors, format=(string)static"), greeting)
            self.assertEqual([bytes.fromhex(frame["memories"][0]) for frame in frames], FRAMES)
            self.assertEqual({frame["command"] for frame in frames}, {"TRANSFER_DATA"})
            self.assertEqual([frame["metadata"] for frame in frames], [[]] * 3)
            self.ends(sink)

    def test_edgesrc_recognises_each_form(self):
        for form in (2088, 168, 160):
            peer, port = self.publisher("--form", str(form), "--caps", CAPS, "01020304,78797a", "05060708,616263")
            out = self.folder / "out"
            source = self.launch(f"edgesrc dest-port={port} num-buffers=2 ! filesink location={out}")
            self.ends(source)
            self.assertEqual(out.read_bytes(), b"\1\2\3\4xyz\5\6\7\x08abc")
            self.assertEqual(peer.wait(SECONDS), 0)

    def test_without_announced_caps_a_capsfilter_decides(self):
        _, port = self.publisher("01020304")
        out = self.folder / "out"
        self.ends(self.launch(f"edgesrc dest-port={port} num-buffers=1 ! other/tensor,dimension=4,type=uint8,framerate=0/1 ! "
                              f"filesink location={out}"))
        self.assertEqual(out.read_bytes(), b"\1\2\3\4")
        _, port = self.publisher("01020304")
        source = self.launch(f"edgesrc dest-port={port} num-buffers=1 ! fakesink async=false")
        self.assertNotEqual(source.wait(SECONDS), 0)
        self.assertIn("needed: a capsfilter with fixed caps", self.output_of(source))

    def test_the_end_of_the_publisher_is_an_error(self):
        _, port = self.publisher("--caps", CAPS, "01020304,78797a")
        source = self.launch(f"edgesrc dest-port={port} ! fakesink async=false")
        self.assertNotEqual(source.wait(SECONDS), 0)
        self.assertIn("the edgesink has closed the connection", self.output_of(source))
        self.assertIn(f"localhost:{port}", self.output_of(source))

    def test_with_reconnect_the_next_publisher_goes_on(self):
        _, port = self.publisher("--caps", CAPS, "01020304,78797a")
        out = self.folder / "out"
        source = self.launch(f"edgesrc dest-port={port} reconnect=true num-buffers=2 ! filesink location={out}")
        peer, _ = self.publisher("--caps", CAPS, "--port", str(port), "05060708,616263") if source.poll() else (None, None)
        while peer is None:  # the port is free when the first has ended
            try:
                with edge_peer.listener(port):
                    pass
                peer, _ = self.publisher("--caps", CAPS, "--port", str(port), "05060708,616263")
            except OSError:
                self.assertIsNone(source.poll(), self.output_of(source))
        self.ends(source)
        self.assertEqual(out.read_bytes(), b"\1\2\3\4xyz\5\6\7\x08abc")


class WithEachOther(Edge):
    def test_frames_arrive_over_tcp(self):
        sink = self.sink("port=0")
        out = self.folder / "out"
        source = self.launch(f"edgesrc dest-port={self.port_of(sink)} num-buffers=3 ! filesink location={out}")
        self.ends(source)
        self.ends(sink)
        self.assertEqual(out.read_bytes(), b"".join(FRAMES))

    def test_frames_and_the_end_arrive_through_shared_memory(self):
        path, out = self.folder / "stream", self.folder / "out"
        data = os.urandom(8 * 5000)
        source = self.launch(f"edgesrc protocol=local path={path} reconnect=true ! filesink location={out}")
        self.ends(self.sink(f"protocol=local path={path}", data))
        self.ends(source)
        self.assertEqual(out.read_bytes(), data)

    def test_a_killed_edgesink_is_replaced(self):
        path, out = self.folder / "stream", self.folder / "out"
        source = self.launch(f"edgesrc protocol=local path={path} reconnect=true ! filesink buffer-mode=unbuffered location={out}")
        first = self.launch("videotestsrc is-live=true pattern=black ! video/x-raw,format=GRAY8,width=4,height=2,framerate=100/1 ! "
                            f"tensor_converter ! edgesink protocol=local path={path}")
        while not out.exists() or out.stat().st_size < 80:
            self.assertIsNone(source.poll(), self.output_of(source))
        first.send_signal(signal.SIGKILL)
        first.wait()
        self.ends(self.sink(f"protocol=local path={path}"))
        self.ends(source)
        written = out.read_bytes()
        self.assertTrue(written.endswith(b"".join(FRAMES)), written[-64:])
        self.assertEqual(set(written[:-24]), {16})

    def test_a_killed_edgesrc_does_not_stop_the_edgesink(self):
        path, out = self.folder / "stream", self.folder / "out"
        sink = self.launch("-e videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=320,height=240,framerate=200/1 ! "
                           f"edgesink protocol=local path={path} max-buffers=2 sync=false")
        first = self.launch(f"edgesrc protocol=local path={path} reconnect=true ! filesink buffer-mode=unbuffered location={out}")
        while not out.exists() or out.stat().st_size < 320 * 240 * 10:
            self.assertIsNone(first.poll(), self.output_of(first))
        first.send_signal(signal.SIGKILL)
        first.wait()
        self.ends(self.launch(f"edgesrc protocol=local path={path} num-buffers=10 ! fakesink"))
        self.assertIsNone(sink.poll(), self.output_of(sink))
        sink.send_signal(signal.SIGINT)
        self.ends(sink)


if __name__ == "__main__":
    tap_runner.main()
