#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes files as a C++ source: embed.py FUNCTION FOLDER OUTPUT GROUP/NAME=KEPT..., with KEPT a path below FOLDER."""

import pathlib
import sys


def literal(text):
    """Returns the bytes as numbers, which need no escaping."""
    return ",".join(str(byte) for byte in text.encode())


def main():
    function, folder, output, names = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]), sys.argv[4:]
    parts = ["// Files of the sources, as apps/weir/embed.py wrote them.", '#include "embedded_files.hpp"',
             "namespace weir::app {", f"namespace {function}_data {{"]
    numbers, rows = {}, []
    for name in names:
        file, _, kept = name.partition("=")
        if kept not in numbers:
            numbers[kept] = len(numbers)
            text = literal((folder / kept).read_text(encoding="utf-8"))
            parts.append(f"constexpr char kText{numbers[kept]}[] = {{{text}}};")
        group, _, file = file.partition("/")
        rows.append(f'{{"{group}", "{file}", {{kText{numbers[kept]}, sizeof kText{numbers[kept]}}}}}')
    parts += [f"constexpr EmbeddedFile kFiles[] = {{{', '.join(rows)}}};", f"}}  // namespace {function}_data",
              f"std::span<const EmbeddedFile> {function}() noexcept {{ return {function}_data::kFiles; }}", "}  // namespace weir::app", ""]
    output.write_text("\n".join(parts), encoding="utf-8")


main()
