# SPDX-License-Identifier: LGPL-2.1-or-later
"""What calls of Weir raise."""


class Error(Exception):
    """Something that Weir refuses, in parts: str(error) is all of them.

    code: its number, one of weir.Code, with a page docs/errors/WEIR-<number>.md
    what: what failed, one sentence
    offered, needed: what came and what would have been right
    difference: the first difference between the two
    fix: a line to paste or a command to run
    All but the first two may be empty.
    """

    def __init__(self, code, what, offered="", needed="", difference="", fix="", message=""):
        super().__init__(message or what)
        self.code = code
        self.what = what
        self.offered = offered
        self.needed = needed
        self.difference = difference
        self.fix = fix
