# SPDX-License-Identifier: LGPL-2.1-or-later
"""The exception that calls of Weir raise."""


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

    def __init__(self, code, what, offered="", needed="", difference="", fix="", message=""):
        super().__init__(message or what)
        self.code = code
        self.what = what
        self.offered = offered
        self.needed = needed
        self.difference = difference
        self.fix = fix

    def __reduce__(self):
        return type(self), (self.code, self.what, self.offered, self.needed, self.difference, self.fix, str(self))

    def __repr__(self):
        return f"<weir.Error {getattr(self.code, 'name', self.code)}: {self.what}>"
