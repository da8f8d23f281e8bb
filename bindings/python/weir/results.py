# SPDX-License-Identifier: LGPL-2.1-or-later
"""Weir Results, version 1, in Python: columns of a stream, and its rows by name.

The format is that of weir/results.h and docs/results.md. Only NumPy is needed: the module works without the libraries.

    columns = parse_columns("x1,y1,x2,y2,score,class;masks")
    for row in rows(columns[0], tensor):          # tensor: bytes, or an array
        print(row.box, row.score, row.class_index)
"""

import dataclasses
import typing

import numpy

VERSION = 1
COLUMNS, SOURCE = "weir-columns", "weir-source"  # caps fields
TRACK_LIMIT = 1 << 24
ROW_LIMIT = 65536  # numbers in a row
TABLES = ("masks", "scores", "class-map", "depth", "text")
EDGES = ("x1", "y1", "x2", "y2")
SINGLE = ("score", "class", "track", "parent", "rotation")


@dataclasses.dataclass(frozen=True)
class Columns:
    """What a tensor holds. `kind` is "rows", the name of a table, or "" for a tensor that is not a result.

    The rest is of rows: `length` numbers in each, and `names`: (name, first number, count) of each column.
    """

    kind: str = ""
    length: int = 0
    names: tuple = ()
    index: typing.Mapping = dataclasses.field(default_factory=dict)  # of the first number, by name
    n_points: int = 0
    point_length: int = 0  # 2: x, y; 3: x, y, score

    def dtype(self):
        """A structured type of one row: fields by column; `box` has the four edges."""
        fields = []
        for name, _first, count in self.names:
            if name == "x1":
                fields.append(("box", "<f4", (4,)))
            elif name in EDGES:
                continue
            elif name in ("xy", "xys"):
                fields.append(("points", "<f4", (count // len(name), len(name))))
            else:
                fields.append((name, "<f4") if count == 1 else (name, "<f4", (count,)))
        return numpy.dtype(fields)


def _column(text, at, found):
    """(name, count of numbers) of the column that begins at number `at`; `found` are those before it."""
    name, separator, number = text.partition(":")
    count = 1
    if separator:
        if not (number.isascii() and number.isdigit()) or not 0 < int(number) <= ROW_LIMIT:
            raise ValueError(f"a column has an unusable count: {text!r}")
        count = int(number)
    if not name:
        raise ValueError("a column has no name")
    if not separator and name in EDGES:
        before = EDGES[EDGES.index(name) - 1] if name != "x1" else None
        if name in found or (before and found.get(before) != at - 1):
            raise ValueError("the edges of the box are not together and in order")
    if not separator and name in SINGLE and name in found:
        raise ValueError(f"a column is there twice: {name}")
    if name in ("xy", "xys"):
        if not separator or "points" in found:
            raise ValueError(f"key points without a count, or twice: {text!r}")
        count *= len(name)
    return name, separator, count


def _parse_entry(text):
    if text == "" or text in TABLES:
        return Columns(kind=text)
    names, found, length, point_length, n_points = [], {}, 0, 0, 0
    for part in text.split(","):
        name, separator, count = _column(part, length, found)
        if length + count > ROW_LIMIT:
            raise ValueError(f"a row has more than {ROW_LIMIT} numbers")
        if name in ("xy", "xys"):
            found["points"], point_length, n_points = length, len(name), count // len(name)
        elif not separator:
            found[name] = length
        names.append((name, length, count))
        length += count
    if 0 < sum(edge in found for edge in EDGES) < 4:
        raise ValueError("the box has fewer than four edges")
    return Columns("rows", length, tuple(names), found, n_points, point_length)


def parse_columns(text):
    """The Columns of each tensor of a weir-columns text. Raises ValueError if it is not valid."""
    return [_parse_entry(entry) for entry in (text or "").split(";")]


@dataclasses.dataclass
class Row:
    """One object. Members that the rows have no column for have their neutral value."""

    box: typing.Optional[tuple]  # x1, y1, x2, y2 in pixels of the source picture
    score: float = 1.0
    class_index: int = 0
    track: int = 0
    parent: int = -1
    rotation: float = 0.0
    points: list = dataclasses.field(default_factory=list)  # (x, y, score) of each
    number: int = 0  # of the row in its tensor

    @property
    def is_background(self):
        return not self.score > 0


def _integer(number, absent):
    """As C's conversion; numbers that no int32 holds are absent."""
    return int(number) if abs(number) < 2147483648.0 else absent


def array(columns, tensor):
    """The numbers of a tensor of rows, one row each. `tensor`: bytes or an array of float32, without a header."""
    if columns.kind != "rows":
        raise ValueError(f"a tensor of {columns.kind or 'no results'} has no rows")
    if isinstance(tensor, numpy.ndarray):
        if tensor.dtype != numpy.float32:
            raise ValueError(f"rows are float32, not {tensor.dtype}")
        numbers = tensor.reshape(-1)
    else:
        if len(tensor) % 4:
            raise ValueError(f"{len(tensor)} bytes are not a number of float32")
        numbers = numpy.frombuffer(tensor, dtype="<f4")
    if numbers.size == 0 or numbers.size % columns.length:
        raise ValueError(f"{numbers.size} numbers are not rows of {columns.length}")
    return numbers.reshape(-1, columns.length)


def structured(columns, tensor):
    """The rows as a structured array (Columns.dtype), background rows too. Copies."""
    numbers = numpy.ascontiguousarray(array(columns, tensor), dtype="<f4")
    names = [name if count == 1 else (name, count) for name, _first, count in columns.names]
    if len(set(names)) != len(names):
        raise ValueError("columns of one name have no structured type")
    return numbers.view(columns.dtype()).reshape(-1)


def _row(columns, numbers, number):
    def one(name, absent):
        return float(numbers[columns.index[name]]) if name in columns.index else absent

    out = Row(box=None, score=one("score", 1.0), class_index=_integer(one("class", 0.0), 0),
              track=max(_integer(one("track", 0.0), 0), 0), parent=_integer(one("parent", -1.0), -1),
              rotation=one("rotation", 0.0), number=number)
    if "x1" in columns.index:
        first = columns.index["x1"]
        out.box = tuple(float(edge) for edge in numbers[first:first + 4])
    if columns.n_points:
        first = columns.index["points"]
        points = numbers[first:first + columns.n_points * columns.point_length].reshape(-1, columns.point_length)
        out.points = [(float(p[0]), float(p[1]), float(p[2]) if columns.point_length == 3 else 1.0) for p in points]
    return out


def rows(columns, tensor, background=False):
    """The rows of a tensor as Row objects; without those that are background, unless asked for."""
    out = [_row(columns, numbers, number) for number, numbers in enumerate(array(columns, tensor))]
    return [row for row in out if background or not row.is_background]


def texts(tensor):
    """The texts of a tensor `text`: an array of uint8, N rows of L bytes. Bytes that are not UTF-8 are replaced."""
    table = numpy.asarray(tensor, dtype=numpy.uint8)
    table = table.reshape(-1, table.shape[-1])
    return [bytes(row).split(b"\0")[0].decode("utf-8", "replace") for row in table]


def sources(text, count):
    """The names of a weir-source text for `count` tensors."""
    names = (text or "").split(";")
    return (names + [""] * count)[:count]
