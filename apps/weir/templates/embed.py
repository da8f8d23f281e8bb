#!/usr/bin/python3
"""Writes the files of a folder of templates as a C++ source: embed.py FOLDER OUTPUT FILE..."""

import pathlib
import sys


def literal(text):
    """Bytes as numbers: no text can end it."""
    return ",".join(str(byte) for byte in text.encode())


def main():
    folder, output, names = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
    parts = ["// The templates of `weir new`, as apps/weir/templates/embed.py wrote them.", '#include "templates.hpp"',
             "namespace weir::app {", "namespace {"]
    rows = []
    for number, name in enumerate(names):
        parts.append(f"constexpr char kText{number}[] = {{{literal((folder / name).read_text(encoding='utf-8'))}}};")
        language, _, file = name.partition("/")
        rows.append(f'{{"{language}", "{file}", {{kText{number}, sizeof kText{number}}}}}')
    parts += [f"constexpr Template kTemplates[] = {{{', '.join(rows)}}};", "}  // namespace",
              "std::span<const Template> filter_templates() noexcept { return kTemplates; }", "}  // namespace weir::app", ""]
    output.write_text("\n".join(parts), encoding="utf-8")


main()
