# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads Weir Results, version 1: the columns of a stream, and its rows by name.

weir/results.h and docs/results.md define the format. Frame.results returns the rows of a frame of weir.Pipeline. For other
tensors, this module needs only NumPy and works without the libraries of Weir.

    columns = parse_columns("x1,y1,x2,y2,score,class;masks")
    for row in rows(columns[0], tensor):          # tensor: bytes, or an array
        print(row.box, row.score, row.class_index)
"""

from __future__ import annotations

import dataclasses
import typing

import numpy

if typing.TYPE_CHECKING:
    import numpy.typing

    Array = numpy.typing.NDArray[typing.Any]

VERSION = 1
COLUMNS, SOURCE = "weir-columns", "weir-source"  # caps fields
TRACK_LIMIT = 1 << 24
ROW_LIMIT = 65536  # numbers in a row
TABLES = ("masks", "scores", "class-map", "depth", "text")
EDGES = ("x1", "y1", "x2", "y2")
SINGLE = ("score", "class", "track", "parent", "rotation")


@dataclasses.dataclass(frozen=True)
class Columns:
    """Describes a tensor. `kind` is "rows", the name of a table, or "" for a tensor that is not a result.

    The other members describe rows. Each row has `length` numbers. `names` has (name, first number, count) for each column.
    """

    kind: str = ""
    length: int = 0
    names: tuple[tuple[str, int, int], ...] = ()
    index: typing.Mapping[str, int] = dataclasses.field(default_factory=dict)  # of the first number, by name
    n_points: int = 0
    point_length: int = 0  # 2: x, y; 3: x, y, score

    def dtype(self) -> numpy.dtype[typing.Any]:
        """Returns a structured type for one row, with a field for each column. `box` has the four edges."""
        fields: list[tuple[typing.Any, ...]] = []
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


def _column(text: str, at: int, found: dict[str, int]) -> tuple[str, str, int]:
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


def _parse_entry(text: str) -> Columns:
    if text == "" or text in TABLES:
        return Columns(kind=text)
    names: list[tuple[str, int, int]] = []
    found: dict[str, int] = {}
    length, point_length, n_points = 0, 0, 0
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


def parse_columns(text: typing.Optional[str]) -> list[Columns]:
    """Returns the Columns of each tensor in a weir-columns text. Raises ValueError if the text is not valid."""
    return [_parse_entry(entry) for entry in (text or "").split(";")]


def _table() -> typing.Any:
    """A member that holds an array: not compared."""
    return dataclasses.field(default=None, compare=False)


@dataclasses.dataclass(repr=False)
class Row:
    """One result, such as a detected object. A member without a column in the rows has its default value.

    Frame.results sets the last members from the labels of the stream and from the other tensors of the frame.
    """

    # x1, y1, x2, y2 in pixels of the source picture; None without these columns, for which type checkers need no check
    box: typing.Union[tuple[float, float, float, float], typing.Any]
    score: float = 1.0
    class_index: int = 0
    track: int = 0  # the number of an object that is followed; 0: none
    parent: int = -1  # the number of the row that this one belongs to; -1: none
    rotation: float = 0.0  # clockwise, in radians
    points: list[tuple[float, float, float]] = dataclasses.field(default_factory=list)  # (x, y, score) of each
    number: int = 0  # of the row in its tensor; in Frame.results in its frame, as `parent` counts
    label: typing.Optional[str] = None  # of the class; None if the stream does not name its classes
    source: str = ""  # what found the object, usually a model
    text: typing.Optional[str] = None
    mask: typing.Optional[Array] = _table()  # uint8, height x width: probabilities 0 to 255 over the box
    scores: typing.Optional[Array] = _table()  # of all classes
    extra: dict[str, typing.Union[float, Array]] = dataclasses.field(default_factory=dict, compare=False)  # other columns

    @property
    def is_background(self) -> bool:
        return not self.score > 0

    def __repr__(self) -> str:
        """The members that are not neutral."""
        neutral: dict[str, typing.Any] = {
            "label": None, "class_index": None, "score": None, "box": None, "track": 0, "parent": -1, "rotation": 0.0, "points": [],
            "text": None, "source": ""}
        parts = [f"{name}={getattr(self, name)!r}" for name in neutral if getattr(self, name) != neutral[name]]
        return f"<weir.results.Row {', '.join(parts)}>"


def _integer(number: float, absent: int) -> int:
    """As C's conversion; numbers that no int32 holds are absent."""
    return int(number) if abs(number) < 2147483648.0 else absent


def array(columns: Columns, tensor: typing.Union[bytes, Array]) -> Array:
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
        numbers = numpy.frombuffer(tensor, dtype="<f4") if tensor else numpy.empty(0, "<f4")
    if numbers.size % columns.length:
        raise ValueError(f"{numbers.size} numbers are not rows of {columns.length}")
    return numbers.reshape(-1, columns.length)


def structured(columns: Columns, tensor: typing.Union[bytes, Array]) -> Array:
    """The rows as a structured array (Columns.dtype), background rows too. Copies."""
    numbers = numpy.ascontiguousarray(array(columns, tensor), dtype="<f4")
    names = {(name, count) for name, _first, count in columns.names}
    if len(names) != len(columns.names):
        raise ValueError("columns of one name have no structured type")
    return numbers.view(columns.dtype()).reshape(-1)


def _row(columns: Columns, numbers: Array, number: int) -> Row:
    def one(name: str, absent: float) -> float:
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
    for name, at, count in columns.names:
        if name not in EDGES + SINGLE + ("xy", "xys"):
            out.extra[name] = float(numbers[at]) if count == 1 else numbers[at:at + count]
    return out


def rows(columns: Columns, tensor: typing.Union[bytes, Array], background: bool = False) -> list[Row]:
    """The rows of a tensor as Row objects; without those that are background, unless asked for."""
    out = [_row(columns, numbers, number) for number, numbers in enumerate(array(columns, tensor))]
    return [row for row in out if background or not row.is_background]


def texts(tensor: Array) -> list[str]:
    """The texts of a tensor `text`: an array of uint8, N rows of L bytes. Bytes that are not UTF-8 are replaced."""
    table = numpy.asarray(tensor, dtype=numpy.uint8)
    table = table.reshape(-1, table.shape[-1])
    return [bytes(row).split(b"\0")[0].decode("utf-8", "replace") for row in table]


def sources(text: typing.Optional[str], count: int) -> list[str]:
    """The names of a weir-source text for `count` tensors."""
    names = (text or "").split(";")
    return (names + [""] * count)[:count]


class _Frame(typing.Protocol):
    """What the functions below use of weir.Frame."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> Array: ...
    def caps_field(self, name: str) -> str: ...
    def label(self, tensor: int, class_index: int) -> typing.Optional[str]: ...
    @property
    def caps(self) -> str: ...


def columns_of_frame(frame: _Frame) -> list[Columns]:
    """What each tensor of the frame holds; Columns of the kind "" for those that are not results."""
    found = parse_columns(frame.caps_field(COLUMNS))
    return (found + [Columns()] * len(frame))[:len(frame)]


def of_frame(frame: _Frame) -> list[Row]:
    """The rows of all tensors of a frame, without background, with their labels, masks, scores and texts."""
    if not frame.caps_field(COLUMNS):
        raise ValueError(f"the stream has no results: its caps are {frame.caps}; put a tensor_decoder before the sink, such as "
                         "tensor_decoder mode=detection")
    columns = columns_of_frame(frame)
    names = sources(frame.caps_field(SOURCE), len(frame))
    out: list[Row] = []
    latest: list[Row] = []  # those that a table belongs to
    for index, entry in enumerate(columns):
        if entry.kind == "rows":
            latest = rows(entry, frame[index], background=True)
            for row in latest:
                row.number += len(out)
                row.source = names[index]
                row.label = frame.label(index, row.class_index)
            out += latest
        elif entry.kind in ("masks", "scores"):
            table = frame[index]
            table = table.reshape((-1,) + table.shape[{"masks": -2, "scores": -1}[entry.kind]:])
            for row, part in zip(latest, table):
                setattr(row, {"masks": "mask", "scores": "scores"}[entry.kind], part)
        elif entry.kind == "text":
            for row, text in zip(latest, texts(frame[index])):
                row.text = text
    return [row for row in out if not row.is_background]


def text_of_frame(frame: _Frame) -> str:
    """The text of a frame of a stream of text; bytes that are not UTF-8 are replaced."""
    media = frame.caps.split(",")[0]
    if not media.startswith(("text/", "application/x-subtitle")) and "json" not in media:
        raise ValueError(f"the stream has no text but {media}: end it with tensor_decoder mode=json ! appsink")
    return frame[0].tobytes().decode("utf-8", "replace")
