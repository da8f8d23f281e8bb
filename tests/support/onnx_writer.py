# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes small ONNX models without a library: only the parts of the format that networks of tests need.

A model is the text of its nodes and the arrays of its weights. Field numbers are those of onnx.proto3.
"""

OPSET, IR_VERSION = 13, 8
FLOAT32 = 1


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out + bytes([value]))


def number(field, value):
    return varint(field << 3) + varint(value)


def block(field, content):
    content = content.encode() if isinstance(content, str) else content
    return varint(field << 3 | 2) + varint(len(content)) + content


def node(operation, inputs, output):
    return block(1, b"".join(block(1, name) for name in inputs) + block(2, output) + block(4, operation))


def weights(name, array):
    dims = b"".join(number(1, n) for n in array.shape)
    return block(5, dims + number(2, FLOAT32) + block(8, name) + block(9, array.astype("<f4").tobytes()))


def value(field, name, shape):
    dims = b"".join(block(1, block(2, n) if isinstance(n, str) else number(1, n)) for n in shape)
    return block(field, block(1, name) + block(2, block(1, number(1, FLOAT32) + block(2, dims))))


def model(nodes, arrays, inputs, outputs, metadata=()):
    """`nodes`: tuples (operation, names of inputs, name of the output); `arrays`: name -> float32 array; `inputs` and
    `outputs`: tuples (name, shape), float32. A text as a length is the name of an open dimension. `metadata`: pairs of texts."""
    graph = b"".join(node(*n) for n in nodes) + block(2, "test")
    graph += b"".join(weights(*item) for item in arrays.items())
    graph += b"".join(value(11, *v) for v in inputs) + b"".join(value(12, *v) for v in outputs)
    return number(1, IR_VERSION) + block(7, graph) + block(8, block(1, "") + number(2, OPSET)) + b"".join(
        block(14, block(1, key) + block(2, text)) for key, text in metadata)
