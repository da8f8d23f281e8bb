# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays arrays through tensor_decoder in a pipeline of gst-launch-1.0."""

import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

from reference_models import LEAKED

SECONDS = 100


class DecoderCase(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(7)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def labels(self, names):
        """The option for a label file."""
        text = "\n".join(names) + "\n"
        return f"option2={self.file('labels.txt', text)}"

    def priors(self, count):
        """Random prior boxes as an array of y, x, height, width, and their file."""
        boxes = np.concatenate([self.random.uniform(0, 1, (2, count)), self.random.uniform(0.1, 0.4, (2, count))]).astype("f4")
        return boxes, self.file("priors.txt", "\n".join(", ".join(f"{v:.9g}" for v in row) for row in boxes))

    def launch(self, line):
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotRegex(done.stderr, LEAKED)

    def source(self, tensors, name="in"):
        """A source of frames of tensors: arrays whose first axis is time."""
        frames = [b"".join(t[i].tobytes() for t in tensors) for i in range(len(tensors[0]))]
        path = self.folder / name
        path.write_bytes(b"".join(frames))
        dims = ",".join(":".join(str(n) for n in reversed(t.shape[1:])) for t in tensors)
        return (f"filesrc location={path} blocksize={len(frames[0])} ! application/octet-stream,framerate=10/1 ! "
                f"tensor_converter input-dim={dims} input-type={','.join(str(t.dtype) for t in tensors)}")

    def decoded(self, tensors, decoder):
        """The bytes that tensor_decoder makes of all frames."""
        self.launch(f"{self.source(tensors)} ! tensor_decoder {decoder} ! filesink location={self.folder / 'out'}")
        return (self.folder / "out").read_bytes()

    def pictures(self, tensors, decoder, size):
        """The frames of RGBA pixels that tensor_decoder draws."""
        return np.frombuffer(self.decoded(tensors, decoder), np.uint8).reshape(len(tensors[0]), size[1], size[0], 4)
