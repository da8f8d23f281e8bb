#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tensor_filter framework=oip with a server of other projects: grpc-js and onnxruntime-node (tests/support/peers)."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

import tap_runner
from built_modules import has_engine
from peer_process import start_peer

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
PEERS = SOURCE / "tests/support/peers"
MODEL = SOURCE / "models/clock_digits.onnx"
FRAMES = 20


class InferencePeers(unittest.TestCase):
    def setUp(self):
        if not has_engine("oip"):
            self.skipTest("the engine oip is not built")
        node = shutil.which("node")
        if not node or not (PEERS / "node_modules").is_dir():
            self.skipTest("the servers of other projects are not installed: tools/setup --peers")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        np.random.default_rng(3).random((FRAMES, 32, 192), np.float32).tofile(self.folder / "in")
        _, port = start_peer(self, node, PEERS / "onnx_server.js", SOURCE / "src/net/protocol/inference.proto", f"digits={MODEL}")
        self.address = f"grpc://127.0.0.1:{port}"

    def play(self, model, out, options="", debug="1"):
        line = (f"filesrc location={self.folder}/in blocksize={4 * 32 * 192} ! "
                f"other/tensor,dimension=(string)1:192:32:1,type=float32,framerate=30/1 ! "
                f"tensor_filter model={model} {options} ! filesink async=false location={self.folder / out}")
        return subprocess.run(["gst-launch-1.0", *line.split()], capture_output=True, text=True, timeout=120,
                              stdin=subprocess.DEVNULL, env={**os.environ, "GST_DEBUG": debug, "GST_TRACERS": ""})

    def test_answers_have_the_bytes_of_the_same_engine_on_this_machine(self):
        if not has_engine("onnxruntime"):
            self.skipTest("the engine onnxruntime is not built")
        remote = self.play(f"{self.address}/digits/1", "remote", "framework=oip", "weir-oip:4")
        local = self.play(MODEL, "local", "framework=onnxruntime threads=1")
        self.assertEqual((remote.returncode, local.returncode), (0, 0), remote.stderr + local.stderr)
        data = (self.folder / "remote").read_bytes()
        self.assertGreater(len(data), FRAMES)
        self.assertEqual(data, (self.folder / "local").read_bytes())
        self.assertRegex(remote.stderr, rf"requests: {FRAMES} sent = {FRAMES} answered \+ 0 late \+ 0 refused \+ 0 lost")

    def test_a_model_that_the_server_does_not_have_is_an_error_with_its_text(self):
        done = self.play(f"{self.address}/other/1", "out", "framework=oip")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("there is no model other (gRPC status 5)", done.stderr)

    def test_contents_that_the_server_does_not_know_are_refused_requests(self):
        done = self.play(f"{self.address}/digits/1", "out", "framework=oip custom=contents:typed", "weir-oip:4")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("only raw contents are known here", done.stderr)
        self.assertRegex(done.stderr, rf"requests: {FRAMES} sent = 0 answered \+ 0 late \+ {FRAMES} refused \+ 0 lost")


if __name__ == "__main__":
    tap_runner.main()
