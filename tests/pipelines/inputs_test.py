#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares tensor_mux, tensor_merge and tensor_crop in whole pipelines with NumPy."""

import pathlib
import struct
import subprocess
import tempfile
import unittest

import numpy as np

import tap_runner
from refusal import refusal

FRAMES = 5
SECONDS = 60


def dims(shape):
    """Formats NumPy's shape, outermost first, as a dimension text."""
    return ":".join(str(n) for n in reversed(shape))


class Inputs(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def numbers(self, shape, dtype):
        return self.random.integers(0, 100, (FRAMES, *shape)).astype(dtype)

    def source(self, name, frames, pad):
        """A stream of tensors from a file."""
        path = self.folder / name
        path.write_bytes(frames.tobytes())
        return (f"filesrc location={path} blocksize={frames[0].nbytes} ! application/octet-stream,framerate=10/1 ! "
                f"tensor_converter input-dim={dims(frames.shape[1:])} input-type={frames.dtype} ! {pad}")

    def run_line(self, *parts):
        out = self.folder / "out"
        line = " ".join([*parts, f"! filesink location={out}"])
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotIn("ERROR", done.stdout + done.stderr)
        return out.read_bytes()

    def test_mux_appends_the_tensors_of_its_pads(self):
        for mode in ("nosync", "slowest", "basepad"):
            inputs = [self.numbers((2, 3), np.uint8), self.numbers((4,), np.float32), self.numbers((1, 5), np.int16)]
            got = self.run_line(*(self.source(f"in{i}", x, "mux.") for i, x in enumerate(inputs)),
                                f"tensor_mux name=mux sync-mode={mode}")
            self.assertEqual(got, b"".join(x[i].tobytes() for i in range(FRAMES) for x in inputs), mode)

    def test_mux_of_twenty_packs_from_the_sixteenth_on(self):
        inputs = [self.numbers((i + 1,), np.uint16) for i in range(20)]
        got = self.run_line(*(self.source(f"in{i}", x, "mux.") for i, x in enumerate(inputs)), "tensor_mux name=mux")
        for frame in range(FRAMES):
            front = b"".join(x[frame].tobytes() for x in inputs[:15])
            self.assertEqual(got[:len(front)], front)
            magic, version, extra, _, size = struct.unpack("<IIIIQ", got[len(front):len(front) + 24])
            self.assertEqual((magic, version, extra, size), (0xF00DC0DE, 0, 4, 32))
            entry = got[len(front) + 24:len(front) + 24 + 80]
            self.assertEqual(struct.unpack("<II", entry[8:16]), (3, 17))
            got = got[len(front) + 19224:]
            back = b"".join(x[frame].tobytes() for x in inputs[15:])
            self.assertEqual(got[:len(back)], back)
            got = got[len(back):]
        self.assertEqual(got, b"")

    def test_merge_is_a_concatenation_along_each_dimension(self):
        for dtype in (np.uint8, np.float32, np.int64):
            for dimension in range(5):
                shapes = [[2, 3, 4, 5, 3] for _ in range(3)]
                for i, shape in enumerate(shapes):
                    shape[4 - dimension] = i + 1
                inputs = [self.numbers(shape, dtype) for shape in shapes]
                got = self.run_line(*(self.source(f"in{i}", x, "merge.") for i, x in enumerate(inputs)),
                                    f"tensor_merge name=merge mode=linear option={dimension}")
                self.assertEqual(got, np.concatenate(inputs, axis=5 - dimension).tobytes(), f"{dtype} {dimension}")

    def test_crop_is_a_slice(self):
        for dtype, info_type in ((np.uint8, np.uint32), (np.float32, np.float32), (np.int64, np.uint16)):
            raw = self.numbers((20, 30, 3), dtype)
            info = np.stack([self.random.integers(0, 28, (FRAMES, 40)), self.random.integers(0, 18, (FRAMES, 40)),
                             self.random.integers(1, 40, (FRAMES, 40)), self.random.integers(1, 40, (FRAMES, 40))],
                            axis=-1).astype(info_type)
            got = self.run_line(self.source("raw", raw, "crop.raw"), self.source("info", info, "crop.info"),
                                "tensor_crop name=crop")
            for frame in range(FRAMES):
                for index, (x, y, w, h) in enumerate(info[frame].astype(int)):
                    if index == 15:
                        got = got[19224:]
                    part = raw[frame, y:y + h, x:x + w]
                    header = struct.unpack("<32I", got[:128])
                    self.assertEqual(header[0], 0xFEEDCCED)
                    self.assertEqual(header[3:6], (3, part.shape[1], part.shape[0]))
                    self.assertEqual(header[19], 1)
                    self.assertEqual(got[128:128 + part.nbytes], part.tobytes())
                    got = got[128 + part.nbytes:]
            self.assertEqual(got, b"")

    def test_a_tee_without_queues_is_reported_where_they_belong(self):
        line = ("videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! tee name=t "
                "t. ! merge.sink_0 t. ! merge.sink_1 tensor_merge name=merge ! fakesink")
        output = refusal(self, line)
        self.assertIn("WEIR-5001", output)
        self.assertIn("fix: t. ! queue ! merge.sink_0   t. ! queue ! merge.sink_1", output)


if __name__ == "__main__":
    tap_runner.main()
