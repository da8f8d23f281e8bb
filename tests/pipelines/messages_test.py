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
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import tap_runner
from built_modules import has_module
from refusal import refusal

SECONDS = 60
FRAMES = 3
SCHEMAS = pathlib.Path(os.environ["WEIR_SOURCE"]) / "src" / "messages"
TYPES = ["int32", "uint32", "int16", "uint16", "int8", "uint8", "float64", "float32", "int64", "uint64", "float16"]
MEDIA = {"protobuf": "other/protobuf-tensor", "flatbuf": "other/flatbuf-tensor", "flexbuf": "other/flexbuf"}


def header(array, fmt=0, media=4):
    """The 128 bytes in front of a flexible tensor (docs/compatibility/types-and-caps.md 1.7)."""
    words = [0xfeedcced, 0xDE001000, TYPES.index(str(array.dtype)), *dims(array), fmt, media]
    return struct.pack(f"<{len(words)}I", *words).ljust(128, b"\0")


def dims(array):
    inner_first = list(reversed(array.shape))
    return inner_first + [0] * (16 - len(inner_first))


class Message:
    """What a library reads from a message, or is to write to one."""

    def __init__(self, arrays, rate=(10, 1), fmt=0, declared=None):
        self.count = len(arrays) if declared is None else declared
        self.rate, self.format = rate, fmt
        self.tensors = [(TYPES.index(str(a.dtype)), dims(a), (header(a) if fmt else b"") + a.tobytes()) for a in arrays]

    def __eq__(self, other):
        return vars(self) == vars(other)

    def __repr__(self):
        return repr(vars(self))


def read_as(count, rate, fmt, tensors):
    out = Message([], rate, fmt)
    out.count, out.tensors = count, tensors
    return out


class Protobuf:
    def __init__(self, folder):
        subprocess.run(["protoc", f"--python_out={folder}", f"--proto_path={SCHEMAS}", "tensors.proto"], check=True)
        sys.path.insert(0, str(folder))
        import tensors_pb2
        self.schema = tensors_pb2

    def read(self, data):
        m = self.schema.Tensors.FromString(data)
        return read_as(m.num_tensor, (m.fr.rate_n, m.fr.rate_d), m.format,
                       [(t.type, list(t.dimension), t.data) for t in m.tensor])

    def write(self, message):
        m = self.schema.Tensors(num_tensor=message.count, format=message.format)
        m.fr.rate_n, m.fr.rate_d = message.rate
        for kind, dimension, data in message.tensors:
            m.tensor.add(name="input", type=kind, dimension=dimension, data=data)
        return m.SerializeToString()


class Flatbuf:
    def __init__(self, folder):
        subprocess.run(["flatc", "--python", "-o", str(folder), str(SCHEMAS / "tensors.fbs")], check=True)
        sys.path.insert(0, str(folder))
        from nnstreamer.flatbuf import Tensor, Tensors, frame_rate
        self.Tensor, self.Tensors, self.frame_rate = Tensor, Tensors, frame_rate

    def read(self, data):
        m = self.Tensors.Tensors.GetRootAs(data, 0)
        tensors = [m.Tensor(i) for i in range(m.TensorLength())]
        return read_as(m.NumTensor(), (m.Fr().RateN(), m.Fr().RateD()), m.Format(),
                       [(t.Type(), t.DimensionAsNumpy().tolist(), t.DataAsNumpy().tobytes()) for t in tensors])

    def write(self, message):
        import flatbuffers
        b = flatbuffers.Builder(16)
        made = []
        for kind, dimension, data in message.tensors:
            name = b.CreateString("input")
            data = b.CreateByteVector(data)
            dimension = b.CreateNumpyVector(np.array(dimension, np.uint32))
            self.Tensor.TensorStart(b)
            self.Tensor.TensorAddName(b, name)
            self.Tensor.TensorAddType(b, kind)
            self.Tensor.TensorAddDimension(b, dimension)
            self.Tensor.TensorAddData(b, data)
            made.append(self.Tensor.TensorEnd(b))
        self.Tensors.TensorsStartTensorVector(b, len(made))
        for tensor in reversed(made):
            b.PrependUOffsetTRelative(tensor)
        vector = b.EndVector()
        self.Tensors.TensorsStart(b)
        self.Tensors.TensorsAddNumTensor(b, message.count)
        self.Tensors.TensorsAddFr(b, self.frame_rate.Createframe_rate(b, *message.rate))
        self.Tensors.TensorsAddTensor(b, vector)
        self.Tensors.TensorsAddFormat(b, message.format)
        b.Finish(self.Tensors.TensorsEnd(b))
        return bytes(b.Output())


class Flexbuf:
    def __init__(self, _):
        from flatbuffers import flexbuffers
        self.flexbuffers = flexbuffers

    def read(self, data):
        m = self.flexbuffers.GetRoot(data).AsMap
        parts = [m[f"tensor_{i}"].AsVector for i in range(m["num_tensors"].AsInt)]
        return read_as(m["num_tensors"].AsInt, (m["rate_n"].AsInt, m["rate_d"].AsInt), m["format"].AsInt,
                       [(p[1].AsInt, [d.AsInt for d in p[2].AsTypedVector], bytes(p[3].AsBlob)) for p in parts])

    def write(self, message):
        b = self.flexbuffers.Builder()
        with b.Map():
            b.UInt("num_tensors", message.count)
            b.Int("rate_n", message.rate[0])
            b.Int("rate_d", message.rate[1])
            b.Int("format", message.format)
            for i, (kind, dimension, data) in enumerate(message.tensors):
                with b.Vector(f"tensor_{i}"):
                    b.String("input")
                    b.Int(kind)
                    b.TypedVectorFromElements(dimension)
                    b.Blob(data)
        return bytes(b.Finish())


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
        self.assertLessEqual({name for name, needed in needs.items() if needed}, formats)
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
