# SPDX-License-Identifier: LGPL-2.1-or-later
"""Messages of tensors by Python's own protobuf, FlatBuffers and FlexBuffers, with the classes that protoc and flatc make of the schemas."""

import os
import pathlib
import struct
import subprocess
import sys

import numpy as np

SCHEMAS = pathlib.Path(os.environ["WEIR_SOURCE"]) / "src" / "messages"
TYPES = ["int32", "uint32", "int16", "uint16", "int8", "uint8", "float64", "float32", "int64", "uint64", "float16"]


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
