# SPDX-License-Identifier: LGPL-2.1-or-later
"""The exception that calls of Weir raise, and the warning of pipelines."""

from __future__ import annotations

import re
import sys
import typing
import warnings

if typing.TYPE_CHECKING:
    from .codes import Code


class Error(Exception):
    """An error reported by Weir; str(error) contains all its parts.

    code: a weir.Code; docs/errors/WEIR-<number>.md describes each
    what: what failed, in one sentence
    offered, needed: the value that was given, and what is needed instead
    difference: the first difference between the two
    fix: a text to paste or a command to run
    All except the first two may be empty.

    Errors can be pickled, so that they pass through multiprocessing and concurrent.futures. If a Python function
    that a pipeline called raised the exception, __cause__ is that exception.
    """

    def __init__(self, code: Code, what: str, offered: str = "", needed: str = "", difference: str = "", fix: str = "",
                 message: str = ""):
        super().__init__(message or what)
        self.code = code
        self.what = what
        self.offered = offered
        self.needed = needed
        self.difference = difference
        self.fix = fix

    def __reduce__(self) -> tuple[typing.Any, ...]:
        return type(self), (self.code, self.what, self.offered, self.needed, self.difference, self.fix, str(self))

    def __repr__(self) -> str:
        return f"<weir.Error {getattr(self.code, 'name', self.code)}: {self.what}>"


class PipelineWarning(RuntimeWarning):
    """A warning that an element of a pipeline posted, such as that a new value of a property is not used.

    Python's warnings module shows it, ignores it or makes an exception of it. error: its parts, as those of a weir.Error
    """

    def __init__(self, error: Error):
        super().__init__(str(error))
        self.error = error


def warn(error: Error) -> None:
    """Issues a weir.PipelineWarning at the line that called the pipeline."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").startswith("weir."):
        level, frame = level + 1, frame.f_back
    warnings.warn(PipelineWarning(error), stacklevel=level)


def _shapes(match: re.Match[str]) -> str:
    """Of C++'s {{1, 4}, {3}}: [(1, 4), (3,)]."""
    shapes = [numbers.split(", ") for numbers in re.findall(r"\{([^{}]*)\}", match[1])]
    return "model.reshape([{}])".format(", ".join("({}{})".format(", ".join(s), "," if len(s) == 1 else "") for s in shapes))


def _model(match: re.Match[str]) -> str:
    paths = [f'"{path}"' for path in match[1].split(",")]
    return f"weir.Model({paths[0]})" if len(paths) == 1 else f"weir.Model([{', '.join(paths)}])"


# How properties of tensor_filter are spelled as arguments of weir.Model.
_SPELLINGS: list[tuple[str, typing.Union[str, typing.Callable[[re.Match[str]], str]]]] = [
    (r"^model=(.+)$", _model),
    (r"\bframework=([\w.-]+)", r'engine="\1"'),
    (r"\baccelerator=([\w:,.-]+)", r'accelerator="\1"'),
    (r"\bcustom=([\w.-]+):(\S+)", r'options={"\1": "\2"}'),
    (r"^(input|inputtype|output|outputtype)=([\w:.,]+)$", r'declared={"\1": "\2"}'),
    (r"^tensor_transform mode=typecast option=(\w+) ! tensor_filter$", r"array.astype(numpy.\1)"),
    (r"model\.reshape\(\{(.*)\}\)", _shapes),
]


def python_spelling(text: str) -> str:
    """Part of an error of a model, with the properties of tensor_filter spelled as arguments of weir.Model."""
    for pattern, spelling in _SPELLINGS:
        text = re.sub(pattern, spelling, text)
    return text
