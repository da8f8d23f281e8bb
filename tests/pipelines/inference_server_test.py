#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tensor_filter framework=oip in whole pipelines, with an inference server of Python's grpcio."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np

import tap_runner
from built_modules import has_engine

SERVER = pathlib.Path(os.environ["WEIR_SOURCE"]) / "tests/support/inference_server.py"
FRAMES = 20


class InferenceServer(unittest.TestCase):
    def setUp(self):
        if not has_engine("oip"):
            self.skipTest("the engine oip is not built")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.frames = np.random.default_rng(1).normal(size=(FRAMES, 4)).astype(np.float32)

    def server(self, *options):
        """The address of the model `affine`, y = 2 x + 1, of a server that this starts."""
        process = subprocess.Popen(["/usr/bin/python3", SERVER, "--classes", os.environ["WEIR_INFERENCE_CLASSES"], *options],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.stdin.close)
        self.addCleanup(process.kill)
        port = re.fullmatch(r"port (\d+)\n", process.stdout.readline())
        self.assertTrue(port, "the server did not start")
        return process, f"grpc://127.0.0.1:{port[1]}/affine/1"

    def play(self, model, options="", data=None, data_type="float32", debug="1"):
        data = self.frames if data is None else data
        (self.folder / "in").write_bytes(data.tobytes())
        line = (f"filesrc location={self.folder}/in blocksize={data[0].nbytes} ! application/octet-stream,framerate=30/1 ! "
                f"tensor_converter input-dim=4:1 input-type={data_type} ! "
                f"tensor_filter framework=oip model={model} {options} ! filesink async=false location={self.folder}/out")
        return subprocess.run(["gst-launch-1.0", *line.split()], capture_output=True, text=True, timeout=120,
                              stdin=subprocess.DEVNULL, env={**os.environ, "GST_DEBUG": debug, "GST_TRACERS": ""})

    def result(self):
        return np.fromfile(self.folder / "out", np.float32).reshape(-1, 4)

    def test_frames_are_answered_in_their_order(self):
        for options in ("", "workers=4"):
            _, model = self.server("--delays", "0.02,0,0.01")
            done = self.play(model, options)
            self.assertEqual(done.returncode, 0, done.stderr)
            np.testing.assert_allclose(self.result(), 2 * self.frames + 1, rtol=1e-6)

    def test_the_log_adds_up_the_requests(self):
        _, model = self.server()
        done = self.play(model, debug="weir-oip:4")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, rf"INFO +weir-oip .*requests: {FRAMES} sent = {FRAMES} answered \+ 0 late \+ 0 refused \+ 0 lost")

    def test_a_second_server_answers_for_one_that_does_not(self):
        (dead, first), (_, second) = self.server(), self.server()
        dead.kill()
        dead.wait()
        done = self.play(f"{first},{second}")
        self.assertEqual(done.returncode, 0, done.stderr)
        np.testing.assert_allclose(self.result(), 2 * self.frames + 1, rtol=1e-6)

    def test_another_type_is_refused_before_it_is_sent(self):
        _, model = self.server()
        done = self.play(model, data=np.arange(8, dtype=np.int32).reshape(2, 4), data_type="int32")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-2001: the stream does not fit the model\n  offered: 1 tensor: int32 4:1", done.stderr)
        self.assertIn("needed: 1 tensor: float32", done.stderr)

    def test_no_server_is_an_error_at_the_start(self):
        process, model = self.server()
        process.kill()
        process.wait()
        done = self.play(model)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-6001", done.stderr)
        self.assertIn(model.split("/")[2], done.stderr)

    def test_another_machine_without_tls_is_an_error(self):
        done = self.play("grpc://192.0.2.1:8001/affine/1")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-6003", done.stderr)
        self.assertIn("grpcs://", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
