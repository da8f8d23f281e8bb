# SPDX-License-Identifier: LGPL-2.1-or-later
"""The exception that calls of Weir raise."""


class Error(Exception):
    """An error reported by Weir; str(error) contains all its parts.

    code: one of weir.Code, documented in docs/errors/WEIR-<number>.md
    what: what failed, in one sentence
    offered, needed: the value that was given, and what is needed instead
    difference: the first difference between the two
    fix: a text to paste or a command to run
    All except the first two may be empty.
    """

    def __init__(self, code, what, offered="", needed="", difference="", fix="", message=""):
        super().__init__(message or what)
        self.code = code
        self.what = what
        self.offered = offered
        self.needed = needed
        self.difference = difference
        self.fix = fix
