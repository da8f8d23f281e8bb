# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the files of the engine `recorded` (tests/support/recorded_engine.cpp): a network that always gives the same outputs."""

import json

import numpy

TYPES = {"int32": 0, "uint32": 1, "int16": 2, "uint16": 3, "int8": 4, "uint8": 5, "float64": 6, "float32": 7, "int64": 8,
         "uint64": 9, "float16": 10}  # weir_type of include/weir/abi.h


def converted(array, kind):
    """The array as `kind` with its scale and zero point: uint8 and int8 cover the range of the numbers."""
    if kind not in ("uint8", "int8") or array.dtype.kind != "f":
        return (array.astype(kind) if array.dtype.kind == "f" else array), 0, 0
    least, most = min(float(array.min()), 0.0), max(float(array.max()), 0.0)
    limits = numpy.iinfo(kind)
    scale = numpy.float32((most - least) / 255 or 1)
    zero_point = int(numpy.clip(round(limits.min - least / scale), limits.min, limits.max))
    return (numpy.round(array / scale) + zero_point).clip(limits.min, limits.max).astype(kind), scale, zero_point


def write(path, size, outputs, kind="float32", metadata=None):
    """`size`: width and height of the input, a picture of uint8; `outputs`: pairs of name and array, outermost dimension
    first. Arrays of integers keep their type; those of floats become `kind`."""
    lines, parts = [f"input {TYPES['uint8']} 1,{size[1]},{size[0]},3"], []
    for name, array in outputs:
        numbers, scale, zero_point = converted(numpy.asarray(array), kind)
        extents = ",".join(str(extent) for extent in numbers.shape)
        lines.append(f"output {TYPES[numbers.dtype.name]} {extents} {scale:.9g} {zero_point} {name or '-'}")
        parts.append(numpy.ascontiguousarray(numbers).tobytes())
    if metadata:
        lines.append("metadata " + json.dumps(metadata))
    path.write_bytes("\n".join([*lines, "end", ""]).encode() + b"".join(parts))
    return path
