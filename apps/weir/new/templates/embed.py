#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes templates as a C++ source: embed.py FOLDER OUTPUT LANGUAGE/FILE=KEPT..., with KEPT a path below FOLDER."""

import pathlib
import sys


def literal(text):
    """Returns the bytes as numbers, which need no escaping."""
    return ",".join(str(byte) for byte in text.encode())


def main():
    folder, output, names = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
    parts = ["// The templates of `weir new`, as apps/weir/new/templates/embed.py wrote them.", '#include "new/templates.hpp"',
             "namespace weir::app {", "namespace {"]
    numbers, rows = {}, []
    for name in names:
        template, _, kept = name.partition("=")
        if kept not in numbers:
            numbers[kept] = len(numbers)
            text = literal((folder / kept).read_text(encoding="utf-8"))
            parts.append(f"constexpr char kText{numbers[kept]}[] = {{{text}}};")
        language, _, file = template.partition("/")
        rows.append(f'{{"{language}", "{file}", {{kText{numbers[kept]}, sizeof kText{numbers[kept]}}}}}')
    parts += [f"constexpr Template kTemplates[] = {{{', '.join(rows)}}};", "}  // namespace",
              "std::span<const Template> filter_templates() noexcept { return kTemplates; }", "}  // namespace weir::app", ""]
    output.write_text("\n".join(parts), encoding="utf-8")


main()
