#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints a C++ header with the text of a file as a constant: embed_text.py CONSTANT FILE."""

import pathlib
import sys

name, path = sys.argv[1], pathlib.Path(sys.argv[2])
print(f"// The text of {path.name}.\n#pragma once\n\nnamespace weir::python {{\n\n"
      f'inline constexpr char {name}[] = R"text({path.read_text()})text";\n\n}}  // namespace weir::python')
