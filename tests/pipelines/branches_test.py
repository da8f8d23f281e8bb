#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares tensor_demux, tensor_split and tensor_if in whole pipelines with NumPy."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import tap_runner

TYPES = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float16", "float32", "float64"]
FRAMES = 4


class Tensor:
    """Frames of one tensor; `dims` innermost first, as in caps."""

    def __init__(self, random, element, dims):
        self.element, self.dims = element, dims
        values = random.integers(0, 100, size=(FRAMES, *reversed(dims)))
        self.frames = values.astype(element)

    def text(self):
        return ":".join(map(str, self.dims))


def caps_of(tensors):
    return f"input-dim={','.join(t.text() for t in tensors)} input-type={','.join(t.element for t in tensors)}"


class Branches(unittest.TestCase):
    def setUp(self):
        self.random = numpy.random.default_rng(7)
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def play(self, tensors, middle, branches, between=""):
        """The bytes that arrived at each branch: "src_0" and so on, or "" for the only one."""
        frames = [b"".join(t.frames[i].tobytes() for t in tensors) for i in range(FRAMES)]
        (self.path / "in").write_bytes(b"".join(frames))
        line = (f"filesrc location={self.path}/in blocksize={len(frames[0])} ! application/octet-stream,framerate=10/1 ! "
                f"tensor_converter {caps_of(tensors)} ! {between}{middle} name=e")
        for name in branches:
            line += f" e.{name} ! queue ! filesink async=false location={self.path}/{name}"
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], timeout=120, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, env=os.environ)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+|CRITICAL|WARNING")
        return [(self.path / name).read_bytes() for name in branches]

    def tensors(self, count, rank=None):
        out = []
        for i in range(count):
            dims = [int(n) for n in self.random.integers(1, 4, size=rank or 1 + i % 16)]
            dims = [n if d < 5 else 1 for d, n in enumerate(dims)]
            out.append(Tensor(self.random, TYPES[int(self.random.integers(len(TYPES)))], dims))
        return out

    def test_demux_gives_each_tensor(self):
        for count in (1, 2, 5, 16, 17, 20):
            tensors = self.tensors(count)
            got = self.play(tensors, "tensor_demux", [f"src_{i}" for i in range(count)])
            for tensor, data in zip(tensors, got):
                with self.subTest(count=count, dims=tensor.text(), element=tensor.element):
                    self.assertEqual(data, tensor.frames.tobytes())

    def test_demux_gives_groups(self):
        a, b, c = tensors = self.tensors(3, rank=3)
        first, second = self.play(tensors, "tensor_demux tensorpick=2,1:0", ["src_0", "src_1"])
        self.assertEqual(first, c.frames.tobytes())
        self.assertEqual(second, b"".join(b.frames[i].tobytes() + a.frames[i].tobytes() for i in range(FRAMES)))

    def test_demux_keeps_the_headers_of_flexible_streams(self):
        tensors = self.tensors(3, rank=4)
        flexible = "other/tensors,format=flexible ! "
        for tensor, data in zip(tensors, self.play(tensors, "tensor_demux", ["src_0", "src_1", "src_2"], flexible)):
            size = 128 + tensor.frames[0].nbytes
            self.assertEqual(len(data), FRAMES * size)
            for i in range(FRAMES):
                chunk = data[i * size:(i + 1) * size]
                self.assertEqual(chunk[:4], bytes.fromhex("edccedfe"))
                self.assertEqual(list(numpy.frombuffer(chunk[12:12 + 16], "<u4")), tensor.dims)
                self.assertEqual(chunk[128:], tensor.frames[i].tobytes())

    def test_split_takes_the_next_bytes_in_the_order_of_the_segments(self):
        tensor = Tensor(self.random, "int16", [3, 4, 5])
        flat = tensor.frames.reshape(FRAMES, -1)
        got = self.play([tensor], "tensor_split tensorseg=3:4:2,7,1:29 tensorpick=2,0", ["src_0", "src_1"])
        self.assertEqual(got[0], flat[:, :24].tobytes())
        self.assertEqual(got[1], flat[:, 31:].tobytes())

    def test_split_cuts_along_any_dimension(self):
        for element in TYPES:
            dims = [int(n) for n in self.random.integers(2, 6, size=4)] + [1] * int(self.random.integers(0, 12))
            tensor = Tensor(self.random, element, dims)
            for dimension in range(4):
                with self.subTest(dims=tensor.text(), element=element, dimension=dimension):
                    axis = len(dims) - dimension  # of all frames in one array, outermost first
                    one, two = self.play([tensor], f"tensor_split split-dim={dimension} tensorseg=1,{dims[dimension] - 1}",
                                         ["src_0", "src_1"])
                    first, second = numpy.split(tensor.frames, [1], axis=axis)
                    self.assertEqual(one, first.tobytes())
                    self.assertEqual(two, second.tobytes())

    def test_if_compares_averages(self):
        for element in TYPES:
            tensors = [Tensor(self.random, "uint8", [3]), Tensor(self.random, element, [5, 7])]
            means = tensors[1].frames.astype("float64").mean(axis=(1, 2)).astype(element)
            limit = sorted(means)[FRAMES // 2]
            with self.subTest(element=element, limit=limit):
                then, other = self.play(
                    tensors, "tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=1 operator=GE "
                    f"supplied-value={float(limit):.17g} then=TENSORPICK then-option=1 else=TENSORPICK else-option=1,0",
                    ["src_0", "src_1"])
                chosen = [i for i in range(FRAMES) if means[i] >= limit]
                self.assertEqual(then, b"".join(tensors[1].frames[i].tobytes() for i in chosen))
                self.assertEqual(other, b"".join(tensors[1].frames[i].tobytes() + tensors[0].frames[i].tobytes()
                                                 for i in range(FRAMES) if i not in chosen))

    def test_if_compares_an_element(self):
        tensor = Tensor(self.random, "int32", [2, 3, 4])
        values = tensor.frames[:, 3, 1, 0]  # coordinate 0:1:3
        low, high = sorted(values)[1:3]
        holds = {"RANGE_INCLUSIVE": (low <= values) & (values <= high),
                 "NOT_IN_RANGE_EXCLUSIVE": (values <= low) | (high <= values), "NE": values != low}
        for operator, mask in holds.items():
            with self.subTest(operator=operator):
                supplied = f"{low}" if operator == "NE" else f"{low},{high}"
                then, other = self.play(
                    [tensor], f"tensor_if compared-value-option=0:1:3,0 operator={operator} supplied-value={supplied}",
                    ["src_0", "src_1"])
                self.assertEqual(then, tensor.frames[mask].tobytes())
                self.assertEqual(other, tensor.frames[~mask].tobytes())


if __name__ == "__main__":
    tap_runner.main()
