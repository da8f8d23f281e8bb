#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes weir/codes.py, the enum weir.Code, from the list in include/weir/codes.h."""

import pathlib
import re
import sys

header, output = map(pathlib.Path, sys.argv[1:])
codes = re.findall(r'X\((\w+), (\d+), "([^"]*)"\)', header.read_text(encoding="utf-8"))
if not codes:
    sys.exit(f"{header} has no line X(NAME, NUMBER, TITLE)")
output.write_text('''# SPDX-License-Identifier: LGPL-2.1-or-later
"""The codes of weir.Error."""

import enum


class Code(enum.IntEnum):
    """The codes of weir.Error. docs/errors has a page for each."""

''' + "".join(f"    {name} = {number}  # {title}\n" for name, number, title in codes), encoding="utf-8")
