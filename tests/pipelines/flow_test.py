#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares tensor_aggregator, tensor_rate, tensor_sparse_enc and -dec, join and tensor_debug with NumPy."""

import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

import numpy

import tap_runner
from refusal import refusal

# In the order of their numbers in headers.
TYPES = ["int32", "uint32", "int16", "uint16", "int8", "uint8", "float64", "float32", "int64", "uint64", "float16"]
FRAMES = 12


def sparse_chunk(array):
    """docs/compatibility/types-and-caps.md 1.7 and 1.8: header, values, flat indices."""
    flat = array.reshape(-1)
    indices = numpy.flatnonzero(flat).astype(numpy.uint32)
    words = [0xFEEDCCED, 0xDE001000, TYPES.index(str(array.dtype)), *reversed(array.shape), *[0] * (16 - array.ndim),
             2, 4, len(indices)]
    return struct.pack("<22I", *words).ljust(128, b"\0") + flat[indices].tobytes() + indices.tobytes()


class Flow(unittest.TestCase):
    def setUp(self):
        self.random = numpy.random.default_rng(4)
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def launch(self, line):
        return subprocess.run(["gst-launch-1.0", *line.split()], timeout=120, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, env=os.environ)

    def play(self, tensors, middle, rate=10, sink="filesink location={}/out"):
        """The output bytes of `middle`; the outermost dimension of the arrays in `tensors` counts frames."""
        frames = [b"".join(t[i].tobytes() for t in tensors) for i in range(len(tensors[0]))]
        (self.path / "in").write_bytes(b"".join(frames))
        dims = ",".join(":".join(map(str, reversed(t.shape[1:]))) for t in tensors)
        types = ",".join(str(t.dtype) for t in tensors)
        done = self.launch(f"filesrc location={self.path}/in blocksize={len(frames[0])} ! "
                           f"application/octet-stream,framerate={rate}/1 ! "
                           f"tensor_converter input-dim={dims} input-type={types} ! {middle} ! {sink.format(self.path)}")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+|CRITICAL|WARNING")
        self.output = done.stderr
        return (self.path / "out").read_bytes()

    def array(self, element, dims, nonzero=1.0):
        values = self.random.integers(1, 100, size=(FRAMES, *reversed(dims)))
        values[self.random.random(values.shape) >= nonzero] = 0
        return values.astype(element)

    def dims(self, rank):
        return [int(n) if d < 4 else 1 for d, n in enumerate(self.random.integers(1, 4, size=rank))]

    def test_windows_are_concatenations(self):
        for rank in range(1, 17):
            for out, flush in ((3, 3), (4, 1), (5, 2)):
                dims = self.dims(rank)
                along = int(self.random.integers(rank))
                array = self.array(TYPES[rank % len(TYPES)], dims)
                with self.subTest(dims=dims, along=along, out=out, flush=flush):
                    got = self.play([array], f"tensor_aggregator frames-out={out} frames-flush={flush} frames-dim={along}")
                    begins = range(0, FRAMES - out + 1, flush)
                    expected = b"".join(numpy.concatenate(list(array[b:b + out]), axis=rank - 1 - along).tobytes()
                                        for b in begins)
                    self.assertEqual(got, expected)

    def test_windows_of_several_tensors(self):
        for count in (2, 16, 17, 20):
            arrays = [self.array(TYPES[i % len(TYPES)], [2, i + 1]) for i in range(count)]
            got = self.play(arrays, "tensor_aggregator frames-out=4 frames-dim=1 ! tensor_aggregator frames-in=4 frames-dim=1 "
                                    "! tensor_sparse_enc ! tensor_sparse_dec ! tensor_demux name=d d.src_1")
            self.assertEqual(got, arrays[1].tobytes(), count)

    def test_sparse_bytes_have_the_documented_layout(self):
        for number, element in enumerate(TYPES):
            array = self.array(element, self.dims(1 + number), nonzero=0.3)
            with self.subTest(element=element):
                got = self.play([array], "tensor_sparse_enc")
                self.assertEqual(got, b"".join(sparse_chunk(frame) for frame in array))
                self.assertEqual(self.play([array], "tensor_sparse_enc ! tensor_sparse_dec"), array.tobytes())

    def test_sparse_files_are_read(self):
        first, second = (self.array("float32", [7], nonzero=0.5)[0] for _ in range(2))
        chunks = sparse_chunk(first) + sparse_chunk(second)
        (self.path / "sparse").write_bytes(chunks)
        read = (f"filesrc location={self.path}/sparse blocksize={len(chunks)} ! other/tensors,format=sparse,framerate=0/1 ! "
                f"tensor_sparse_dec ! filesink location={self.path}/out")
        self.assertEqual(self.launch(read).returncode, 0)
        self.assertEqual((self.path / "out").read_bytes(), first.tobytes() + second.tobytes())
        (self.path / "sparse").write_bytes(chunks[:-1])
        self.assertIn("WEIR-2005: a tensor header declares more bytes than its memory holds", refusal(self, read))

    def test_a_rate_takes_the_nearest_frames(self):
        array = self.array("uint8", [3])
        self.assertEqual(self.play([array], "tensor_rate framerate=5/1"), array[::2].tobytes())
        twice = self.play([array], "tensor_rate framerate=20/1")
        # The frame of the last tick is sent only once.
        self.assertEqual(twice, numpy.repeat(array, 2, axis=0)[:-1].tobytes())

    def test_a_rate_that_cannot_be_read_is_reported_when_the_pipeline_starts(self):
        done = self.launch("videotestsrc num-buffers=2 ! video/x-raw,format=GRAY8 ! tensor_converter ! tensor_rate framerate=30/x"
                           " ! fakesink")
        self.assertEqual(done.returncode, 0)
        self.assertIn("WEIR-1001: framerate cannot be read and is ignored", done.stderr + done.stdout)

    def test_branches_join_in_order(self):
        array = self.array("uint8", [2, 1])
        got = self.play([array], "tensor_if name=i compared-value=A_VALUE compared-value-option=0:0,0 operator=GE "
                                 "supplied-value=50 i.src_0 ! j.sink_0 i.src_1 ! j.sink_1 join name=j")
        self.assertEqual(got, array.tobytes())

    def test_debug_logs_what_passes_and_changes_nothing(self):
        array = self.array("uint8", [2])
        quiet = self.play([array], "other/tensors,format=static ! tensor_debug name=d")
        self.assertEqual(quiet, array.tobytes())
        self.assertNotIn("d: info:", self.output)
        loud = self.play([array], "other/tensors,format=static ! tensor_debug name=d silent=false capability=always")
        self.assertEqual(loud, array.tobytes())
        lines = [line for line in self.output.splitlines() if line.startswith("d: info:")]
        self.assertEqual(lines, ["d: info: 1 tensor: uint8 2 at 10/1"] +
                         [f"d: info: frame {i}: 1 memory, 2 bytes" for i in range(FRAMES)])

    def test_windows_that_cannot_be_are_refused(self):
        source = "videotestsrc num-buffers=2 ! video/x-raw,format=GRAY8,width=10,height=4 ! tensor_converter ! "
        for properties, words in (("frames-out=2 frames-flush=3", "frames-flush exceeds the number of frames"),
                                  ("frames-in=3 frames-dim=1", "dimension 1 of tensor 0 (uint8 1:10:4:1) is 10")):
            self.assertIn(words, refusal(self, f"{source}tensor_aggregator {properties} ! fakesink"))


if __name__ == "__main__":
    tap_runner.main()
