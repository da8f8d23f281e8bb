# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts lines of code: Python statements' lines by Python's own tokenizer, pipelines by their elements.

A line counts if it has a token of code: no comment, no docstring, no empty line. Of a pipeline each element is a line, as people write
it. Networks, options of the command line and what only measures do not count on either side.
"""

import ast
import io
import pathlib
import tokenize

SKIPPED = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING, tokenize.ENDMARKER)
# The functions of the control that each variant needs.
COMMON = ("get_items", "Stages", "read_frames", "windows", "infer", "names")
NEEDS = {"a": ("normalised", "event_results", "variant_a"), "b": ("normalised", "event_results", "sequence_results", "variant_b"),
         "c": ("standardised", "radio_results", "variant_c"),
         "bc": ("normalised", "standardised", "event_results", "sequence_results", "radio_results", "with_nearest", "variant_bc")}


def lines_with_code(text):
    """The numbers of the lines of Python that count."""
    found = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in SKIPPED:
            found |= set(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node) is not None:
            found -= set(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return found


def of_control(path, variant):
    text = pathlib.Path(path).read_text()
    counted, needed = lines_with_code(text), (*COMMON, *NEEDS[variant])
    total = 0
    for node in ast.parse(text).body:
        named = isinstance(node, (ast.FunctionDef, ast.ClassDef))
        if (named and node.name in needed) or isinstance(node, (ast.Import, ast.ImportFrom, ast.Assign)):
            total += len(counted & set(range(node.lineno, node.end_lineno + 1)))
    return total


def of_pipeline(line):
    """Elements and caps, one a line; properties and the names of pads belong to their element."""
    words = [word for word in line.split() if word != "!"]
    return sum(word.startswith("application/") or ("=" not in word and "." not in word) for word in words)
