#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests the types of the package weir: the stub names what the extension module has, and mypy accepts the package and finds
mistakes in programs that use it. Without mypy (Debian: python3-mypy) only the names are compared."""

import ast
import inspect
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import tap_runner

try:
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

FOLDER = pathlib.Path(weir.__file__).parent
HEADER = pathlib.Path(__file__).resolve().parents[2] / "include" / "weir" / "codes.h"
HAS_MYPY = subprocess.run([sys.executable, "-m", "mypy", "--version"], capture_output=True, check=False).returncode == 0
# What the metaclass of pybind11 gives every class: no part of the interface.
PYBIND11 = r"""
weir\._weir\.\w+
weir\._weir\.(Frame|SourceMap|TensorInfo)\.__init__
"""


def run(*arguments, **more):
    return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False, **more)


def public_members(of):
    return {name for name in vars(of) if not name.startswith("__") and name != "_pybind11_conduit_v1_"}


class Stub(unittest.TestCase):
    def test_names_what_the_module_has(self):
        tree = ast.parse((FOLDER / "_weir.pyi").read_text())
        classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        self.assertEqual(set(classes), {name for name, value in vars(weir._weir).items() if inspect.isclass(value)})
        for name, node in classes.items():
            stubbed = {part.name for part in node.body if isinstance(part, ast.FunctionDef) and not part.name.startswith("__")}
            self.assertEqual(stubbed, public_members(getattr(weir._weir, name)), name)

    def test_the_package_has_types_and_docstrings(self):
        self.assertTrue((FOLDER / "py.typed").exists())
        for name in weir.__all__:
            self.assertTrue(inspect.getdoc(getattr(weir, name)), name)
        for of in (weir.Frame, weir.SourceMap, weir.Model, weir.Pipeline, weir._weir.Pipeline, weir._weir.Model):
            for name in public_members(of):
                if not name.startswith("_"):
                    self.assertTrue(inspect.getdoc(getattr(of, name)), f"{of.__name__}.{name}")

    def test_codes_are_those_of_the_header(self):
        codes = re.findall(r"X\((\w+), (\d+),", HEADER.read_text())
        self.assertEqual([(code.name, int(code)) for code in weir.Code], [(name, int(number)) for name, number in codes])


@unittest.skipUnless(HAS_MYPY, "mypy is not installed: apt-get install python3-mypy")
class Mypy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)  # what mypy keeps is for all cases, as NumPy's types take it seconds to read

    def mypy(self, program):
        path = self.folder / "program.py"
        path.write_text("import numpy\nimport weir\n" + program)
        return run("mypy", "--strict", str(path), cwd=self.folder).stdout

    def test_accepts_the_package(self):
        done = run("mypy", "--strict", "-p", "weir", cwd=self.folder)
        self.assertIn("Success: no issues found", done.stdout)

    def test_finds_no_difference_between_stub_and_module(self):
        allowed = self.folder / "allowed"
        allowed.write_text(PYBIND11)
        done = run("mypy.stubtest", "weir._weir", "--allowlist", str(allowed), cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_accepts_a_program(self):
        self.assertIn("Success", self.mypy("""
for frame in weir.Pipeline("appsrc ! tensor_sink name=out").frames("out"):
    for row in frame.results:
        if row.box is not None:
            x: float = row.box[0]
model = weir.Model("net.onnx", threads=1)
if outputs := model(numpy.zeros(3)):
    print(outputs["scores"].shape, outputs[0].dtype, weir.Code.SPEC_MISMATCH)
"""))

    def test_accepts_what_the_documents_show(self):
        self.assertIn("Success", self.mypy("""
scores, = weir.Model("net.onnx")(numpy.zeros(3))
for frame in weir.Pipeline("appsrc ! tensor_sink name=out").frames("out"):
    print(frame.pts / 1e9, frame.duration + 1, frame.source_map.to_source(1, 2), scores.mean())
    for found in frame.results:
        x1, y1, x2, y2 = found.box
"""))
        guide = (HEADER.parents[2] / "docs/guide/python.md").read_text()
        for program in re.findall(r"(?ms)^```python\n(.*?)^```", guide):
            found = self.mypy(program)
            self.assertNotRegex(found, r"error: (?!Function is missing a type annotation)", program)

    def test_finds_mistakes(self):
        mistakes = {"weir.Pipeline('a').pull(1)": 'incompatible type "int"; expected "str"',
                    "weir.Pipeline('a').pul('out')": 'has no attribute "pul"',
                    "weir.Pipeline('a').pull('out').pts": 'Item "None" of "Optional[Frame]"',
                    "weir.Code.NO_SUCH": 'has no attribute "NO_SUCH"'}
        found = self.mypy("\n".join(mistakes) + "\n")
        for line, message in enumerate(mistakes.values(), 3):
            self.assertRegex(found, rf"program.py:{line}: error: .*{re.escape(message)}")


if __name__ == "__main__":
    tap_runner.main()
