# SPDX-License-Identifier: LGPL-2.1-or-later
"""The commands of a page in Markdown and what it says that they print."""

import re

NUMBER = r"-?\d+(?:\.\d+)?"


def blocks(page):
    """(commands, output, whether they go on) of each ```sh block, which is ```sh server where they are to run until the page ends.

    The output is that of a ```text block after it, with at most one paragraph that ends with a colon between them, else None.
    """
    found = re.finditer(r"^```sh( server)?\n(.*?)^```\n(?:\n?(?:[^\n`][^`]*?:\n\n)?```text\n(.*?)^```$)?", page, re.MULTILINE | re.DOTALL)
    return ((block[2], block[3], bool(block[1])) for block in found)


def line_fits(expected, printed):
    """Equal but for numbers that differ a little (0.02 below 2, otherwise 1.5) and `...`, which is anything."""
    parts = re.split(rf"(\.\.\.|{NUMBER})", expected.rstrip())
    pattern = "".join(".*" if part == "..." else f"({NUMBER})" if re.fullmatch(NUMBER, part) else re.escape(part) for part in parts)
    match = re.fullmatch(pattern, printed.rstrip())
    numbers = [float(part) for part in parts if re.fullmatch(NUMBER, part)]
    return bool(match) and all(abs(float(got) - want) <= (0.02 if abs(want) < 2 else 1.5)
                               for want, got in zip(numbers, match.groups()))


def difference(expected, printed):
    """None if the output is what the page says; otherwise the first line that is not."""
    lines, wanted = printed.splitlines(), expected.splitlines()
    for number, line in enumerate(wanted):
        if line == "...":
            rest = "".join(f"{later}\n" for later in wanted[number + 1:])
            if any(difference(rest, "\n".join(lines[skip:])) is None for skip in range(len(lines) + 1)):
                return None
            return f"after ...: {rest}"
        if not lines or not line_fits(line, lines[0]):
            return f"the page says: {line}\nprinted: {lines[0] if lines else 'nothing'}"
        lines = lines[1:]
    return f"the page ends before: {lines[0]}" if lines else None
