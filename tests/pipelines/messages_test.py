#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Exchanges messages of tensors with Python's own protobuf and FlatBuffers, in both directions.

The classes are those that protoc and flatc make of the schemas in src/messages.
"""

import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import tap_runner
from built_modules import has_module
from refusal import refusal
from tensor_messages import TYPES, Flatbuf, Flexbuf, Message, Protobuf, header

SECONDS = 60
FRAMES = 3
MEDIA = {"protobuf": "other/protobuf-tensor", "flatbuf": "other/flatbuf-tensor", "flexbuf": "other/flexbuf"}
NEEDS = {"protobuf": ("protoc", "google.protobuf", Protobuf), "flatbuf": ("flatc", "flatbuffers", Flatbuf),
         "flexbuf": ("flatc", "flatbuffers", Flexbuf)}


def has_python(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


class Messages(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    libraries = {}
    classes = tempfile.TemporaryDirectory()

    def formats(self):
        """The formats that were built and whose library Python has."""
        for name, (compiler, module, make) in NEEDS.items():
            if not has_module("decoder", name) or not shutil.which(compiler) or not has_python(module):
                print(f"skipped: {name} was not built, or {compiler} or Python's {module} is not here", file=sys.stderr)
                continue
            if name not in self.libraries:
                self.libraries[name] = make(pathlib.Path(self.classes.name))
            for old in self.folder.iterdir():
                old.unlink()
            yield name, self.libraries[name]

    def launch(self, line):
        done = subprocess.run(["gst-launch-1.0", "-v", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL)
        output = done.stdout + done.stderr
        self.assertEqual(done.returncode, 0, output)
        self.assertNotIn("CRITICAL", output)
        return output

    def frames(self, *tensors):
        """FRAMES lists of arrays of these shapes and types."""
        return [[self.random.integers(0, 100, shape).astype(dtype) for shape, dtype in tensors] for _ in range(FRAMES)]

    def written(self, name, frames, convert):
        """The messages that a pipeline makes of the frames."""
        path = self.folder / "frames"
        path.write_bytes(b"".join(a.tobytes() for frame in frames for a in frame))
        size = sum(a.nbytes for a in frames[0])
        shapes = ",".join(":".join(str(n) for n in reversed(a.shape)) for a in frames[0])
        types = ",".join(str(a.dtype) for a in frames[0])
        self.launch(f"filesrc location={path} blocksize={size} ! application/octet-stream,framerate=10/1 ! "
                    f"tensor_converter input-dim={shapes} input-type={types} ! {convert} tensor_decoder mode={name} ! "
                    f"{MEDIA[name]} ! multifilesink location={self.folder}/message.%02d")
        return [(self.folder / f"message.{i:02}").read_bytes() for i in range(FRAMES)]

    def converted(self, name, messages, rest=""):
        """The bytes of the stream that a pipeline makes of the messages, and its output."""
        for i, message in enumerate(messages):
            (self.folder / f"in.{i:02}").write_bytes(message)
        out = self.folder / "out"
        output = self.launch(f"multifilesrc location={self.folder}/in.%02d stop-index={len(messages) - 1} "
                           f"caps={MEDIA[name]},framerate=10/1 ! tensor_converter {rest} ! filesink location={out}")
        return out.read_bytes(), output

    def test_a_library_reads_what_the_decoder_writes(self):
        for name, library in self.formats():
            with self.subTest(name):
                frames = self.frames(((2, 3), np.uint8), ((4,), np.float32), ((1, 5), np.int16), ((7,), np.uint8))
                messages = self.written(name, frames, "other/tensors,format=static !")
                self.assertEqual([library.read(m) for m in messages], [Message(f) for f in frames])

    def test_a_library_reads_flexible_tensors_with_their_headers(self):
        for name, library in self.formats():
            with self.subTest(name):
                frames = self.frames(((2, 3), np.uint8), ((4,), np.float64))
                messages = self.written(name, frames, "other/tensors,format=flexible !")
                wanted = [Message(f, fmt=1) for f in frames]
                for message, frame in zip(wanted, frames):  # from octets: media type 3
                    message.tensors = [(k, d, header(a, media=3) + a.tobytes()) for (k, d, _), a in zip(message.tensors, frame)]
                self.assertEqual([library.read(m) for m in messages], wanted)

    def test_protobuf_bytes_are_those_of_the_library(self):
        for name, library in self.formats():
            if name == "protobuf":
                frames = self.frames(((2, 300), np.uint8), ((4,), np.int32))
                for data, frame in zip(self.written(name, frames, "other/tensors,format=static !"), frames):
                    parsed = library.schema.Tensors.FromString(data)
                    self.assertEqual(parsed.SerializeToString(), data)
                    self.assertEqual(len(parsed.UnknownFields()), 0)

    def test_the_converter_reads_what_a_library_writes(self):
        for name, library in self.formats():
            with self.subTest(name):
                frames = self.frames(((2, 3), np.uint8), ((4,), np.float32), ((1, 5), np.int64))
                got, output = self.converted(name, [library.write(Message(f, rate=(25, 1))) for f in frames])
                self.assertEqual(got, b"".join(a.tobytes() for f in frames for a in f))
                self.assertIn("dimensions=(string)1:1:1:1", output, "before the first message")
                for words in ("num_tensors=(int)3", "3:2:1:1", "framerate=(fraction)25/1", "uint8,float32,int64"):
                    self.assertIn(words, output.replace("\\,", ",").replace("3:2,", "3:2:1:1,"))

    def test_each_type_passes_in_both_directions(self):
        for name, library in self.formats():
            for dtype in TYPES:
                with self.subTest(name, dtype=dtype):
                    frames = self.frames(((3, 2), dtype))
                    messages = self.written(name, frames, "other/tensors,format=static !")
                    self.assertEqual([library.read(m) for m in messages], [Message(f) for f in frames])
                    got, output = self.converted(name, [library.write(Message(f)) for f in frames])
                    self.assertEqual(got, b"".join(f[0].tobytes() for f in frames))
                    self.assertIn(f"types=(string){dtype}", output)

    def test_the_converter_reads_flexible_tensors(self):
        for name, library in self.formats():
            with self.subTest(name):
                frames = [[np.arange(n, dtype=np.uint16)] for n in (3, 5, 2)]
                got, output = self.converted(name, [library.write(Message(f, fmt=1)) for f in frames])
                self.assertEqual(got, b"".join(header(f[0]) + f[0].tobytes() for f in frames))
                self.assertIn("format=(string)flexible", output)

    def test_caps_with_what_the_messages_hold_are_met_after_the_first(self):
        for name, library in self.formats():
            with self.subTest(name):
                frames = self.frames(((2, 3), np.uint8))
                caps = "other/tensors,format=static,num_tensors=1,dimensions=(string)3:2,types=(string)uint8,framerate=25/1"
                got, output = self.converted(name, [library.write(Message(f, rate=(25, 1))) for f in frames], f"! {caps}")
                self.assertEqual(got, b"".join(f[0].tobytes() for f in frames))
                self.assertNotIn("dimensions=(string)1:1:1:1", output, "the placeholder is refused here")

    def test_only_the_modules_of_a_format_need_its_library(self):
        build = pathlib.Path(os.environ["WEIR_BUILD"])
        needs = {}
        for path in build.glob("src/**/lib*.so*"):
            if path.is_file() and re.fullmatch(r"lib(gst)?weir[\w-]*\.so[.\d]*", path.name):
                table = subprocess.run(["readelf", "-d", str(path)], capture_output=True, text=True, check=True).stdout
                needs[path.name] = "libprotobuf" in table or "libflatbuffers" in table
        self.assertGreater(len(needs), 10)
        formats = {f"libweir-{kind}-{name}.so" for kind in ("decoder", "converter") for name, _ in self.formats()}
        self.assertLessEqual({name for name, needed in needs.items() if needed}, formats | {"libgstweirnet.so"})  # the gRPC elements
        for name in formats & {"libweir-decoder-protobuf.so", "libweir-converter-protobuf.so"}:
            self.assertTrue(needs[name], name)

    def test_shapes_may_change_from_message_to_message(self):
        for name, library in self.formats():
            with self.subTest(name):
                frames = [[np.arange(n, dtype=np.uint8)] for n in (3, 5, 2)]
                got, output = self.converted(name, [library.write(Message(f)) for f in frames])
                self.assertEqual(got, b"".join(f[0].tobytes() for f in frames))
                for n in (3, 5, 2):
                    self.assertIn(f"dimensions=(string){n}, ", output)

    def test_inconsistent_messages_end_the_pipeline_with_the_reason(self):
        array = np.arange(6, dtype=np.uint8)
        short = Message([array])
        short.tensors = [(5, [7] + [0] * 15, array.tobytes())]
        for name, library in self.formats():
            for message, words in ((Message([array], declared=2), "the number of tensors that it declares"),
                                   (short, "needed: 7 bytes for uint8 7"), (Message([array], fmt=2), "sparse tensors"),
                                   (Message([array] * 257), "at most 256")):
                with self.subTest(name, words=words):
                    (self.folder / "in.00").write_bytes(library.write(message))
                    output = refusal(self, f"multifilesrc location={self.folder}/in.%02d stop-index=0 "
                                         f"caps={MEDIA[name]},framerate=10/1 ! tensor_converter ! fakesink")
                    self.assertIn(words, output)
                    self.assertIn(f"a {name} message", output)


if __name__ == "__main__":
    tap_runner.main()
