#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares four streams batched through one model with four separate filters."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import onnx_writer
import tap_runner

STREAMS, FRAMES, SIZE, CHANNELS = 4, 50, 8, 4
HAS_ONNX = "onnxruntime" in os.environ["WEIR_MODULE_PATH"]


def model():
    """tanh(x W + b) for each pixel x, for any number of pictures."""
    random = numpy.random.default_rng(7)
    arrays = {"W": random.normal(0, 0.02, (1, CHANNELS)).astype("f4"), "b": random.normal(0, 1, CHANNELS).astype("f4")}
    nodes = [("MatMul", ["x", "W"], "xw"), ("Add", ["xw", "b"], "s"), ("Tanh", ["s"], "y")]
    picture = ("n", SIZE, SIZE)
    return onnx_writer.model(nodes, arrays, [("x", (*picture, 1))], [("y", (*picture, CHANNELS))])


@unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
class Batching(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.model = pathlib.Path(self.folder.name) / "pixels.onnx"
        self.model.write_bytes(model())

    def branch(self, stream, properties):
        """A picture stream with its own frame rate; the results go to a file."""
        path = pathlib.Path(self.folder.name) / f"{stream}.raw"
        return (f"videotestsrc pattern=zone-plate kx2=20 ky2=20 kt={stream + 1} num-buffers={FRAMES} ! "
                f"video/x-raw,format=GRAY8,width={SIZE},height={SIZE},framerate=30/1 ! tensor_converter ! "
                f"tensor_transform mode=typecast option=float32 ! tensor_filter model={self.model} {properties} ! "
                f"filesink location={path}"), path

    def run_streams(self, streams, properties):
        branches = [self.branch(stream, properties) for stream in streams]
        line = "gst-launch-1.0 -q " + "  ".join(text for text, _path in branches)
        done = subprocess.run(line.split(), capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+|CRITICAL|WARNING|ERROR")
        return [numpy.fromfile(path, "f4").reshape(-1, SIZE, SIZE, CHANNELS) for _text, path in branches]

    def test_streams_get_what_they_get_alone(self):
        alone = [self.run_streams([stream], "")[0] for stream in range(STREAMS)]
        for a in range(STREAMS):
            self.assertEqual(len(alone[a]), FRAMES)
            for b in range(a):
                self.assertGreater(abs(alone[a] - alone[b]).max(), 0.1, "the streams differ")
        for size in (4, 3, 16):
            together = self.run_streams(range(STREAMS), f"shared-tensor-filter-key=pixels batch-size={size}")
            for stream in range(STREAMS):
                self.assertEqual(together[stream].shape, alone[stream].shape)
                numpy.testing.assert_allclose(together[stream], alone[stream], atol=1e-5)


if __name__ == "__main__":
    tap_runner.main()
