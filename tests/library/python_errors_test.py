#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of weir.Error: how it looks, that it can be pickled, and which exception it was raised from."""

import copy
import os
import pathlib
import pickle
import shutil
import subprocess
import sys
import tempfile
import traceback
import unittest

import tap_runner

try:
    import numpy as np
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

LOOP = "appsrc name=in ! tensor_sink name=out"
PARTS = ("code", "what", "offered", "needed", "difference", "fix")


def error_of(call, *arguments, **more):
    try:
        call(*arguments, **more)
    except weir.Error as error:
        return error
    raise AssertionError("nothing was raised")


class Errors(unittest.TestCase):
    def test_copies_and_pickles_are_whole(self):
        error = error_of(weir.Model, "/no/such/file.onnx")
        for other in (copy.copy(error), *(pickle.loads(pickle.dumps(error, n)) for n in range(pickle.HIGHEST_PROTOCOL + 1))):
            self.assertIs(type(other), weir.Error)
            self.assertIs(type(other.code), weir.Code)
            self.assertEqual(str(other), str(error))
            for part in PARTS:
                self.assertEqual(getattr(other, part), getattr(error, part), part)
        self.assertIn("WEIR-3003", str(error))

    def test_repr_names_the_code(self):
        self.assertEqual(repr(error_of(weir.Model, "/no/such/file.onnx")),
                         "<weir.Error MODEL_NOT_FOUND: the model file does not exist>")
        self.assertEqual(repr(weir.Error(7, "lost")), "<weir.Error 7: lost>")

    def test_the_exception_of_a_function_is_the_cause(self):
        pipeline = weir.Pipeline(LOOP)

        def fail(frame):
            raise KeyError("not this one")

        pipeline.on_frame("out", fail)
        with pipeline:
            pipeline.push("in", np.zeros(1, np.uint8))
            error = error_of(pipeline.wait, 60)
        self.assertEqual(error.code, weir.Code.CALLBACK_FAILED)
        self.assertIsInstance(error.__cause__, KeyError)
        self.assertEqual(error.__cause__.args, ("not this one",))
        self.assertIn("in fail", "".join(traceback.format_exception(error)))

    def test_a_function_without_lines_of_python_can_raise_too(self):
        pipeline = weir.Pipeline(LOOP)
        pipeline.on_frame("out", int)
        with pipeline:
            pipeline.push("in", np.zeros(1, np.uint8))
            error = error_of(pipeline.wait, 60)
        self.assertIsInstance(error.__cause__, TypeError)
        self.assertIn("int() argument must be", str(error))

    def test_other_errors_have_no_cause(self):
        pipeline = weir.Pipeline(LOOP)
        pipeline.on_frame("out", lambda frame: 1 / 0)
        with pipeline:
            pipeline.push("in", np.zeros(1, np.uint8))
            self.assertIsInstance(error_of(pipeline.wait, 60).__cause__, ZeroDivisionError)
            self.assertIsNone(error_of(pipeline.get, "in", "no-such-property").__cause__)
        self.assertIsNone(error_of(pipeline.push, "in", np.zeros(1, np.uint8)).__cause__)


class Package(unittest.TestCase):
    def test_has_a_version(self):
        self.assertRegex(weir.__version__, r"^\d+\.\d+\.\d+$")

    def test_repr_of_a_pipeline(self):
        pipeline = weir.Pipeline(LOOP)
        self.assertEqual(repr(pipeline), f"<weir.Pipeline stopped: {LOOP}>")
        with pipeline:
            self.assertEqual(repr(pipeline), f"<weir.Pipeline playing: {LOOP}>")
        pipeline.close()
        self.assertTrue(pipeline.closed)
        self.assertEqual(repr(pipeline), f"<weir.Pipeline closed: {LOOP}>")


class Import(unittest.TestCase):
    """What a program says when a part of the package is missing: in copies of the package."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        shutil.copytree(pathlib.Path(weir.__file__).parent, self.folder / "weir", ignore=shutil.ignore_patterns("*.p", "__pycache__"))
        self.extension, = (self.folder / "weir").glob("_weir.*.so")

    def error(self, before="pass"):
        done = subprocess.run([sys.executable, "-c", f"{before}; import weir"], capture_output=True, text=True, check=False, timeout=60,
                              env={**os.environ, "PYTHONPATH": str(self.folder)})
        self.assertEqual(done.returncode, 1)
        return done.stderr

    def test_for_another_python(self):
        self.extension.rename(self.extension.with_name("_weir.cpython-399-x86_64-linux-gnu.so"))
        self.assertIn("weir was built for another Python: it has _weir.cpython-399-x86_64-linux-gnu.so, and this is /usr/bin/python3",
                      self.error())

    def test_without_the_extension_module(self):
        self.extension.unlink()
        self.assertIn("the package weir has no extension module in ", self.error())

    def test_with_an_extension_module_that_cannot_be_loaded(self):
        self.extension.write_bytes(b"no library")
        self.assertRegex(self.error(), r"weir cannot be loaded by /usr/bin/python3.*, which is Python 3.*_weir.*: ")

    def test_without_numpy(self):
        (self.folder / "numpy.py").write_text("raise ModuleNotFoundError(\"No module named 'numpy'\", name='numpy')")
        self.assertIn("No module named 'numpy', which weir needs: apt-get install python3-numpy\n", self.error())
        # An interpreter of pyenv or of a virtual environment does not see Debian's package.
        other = self.error("import sys; sys.prefix, sys.executable = '/opt/pyenv/3.11', '/opt/pyenv/3.11/bin/python'")
        self.assertIn("No module named 'numpy' in /opt/pyenv/3.11/bin/python, and weir needs it: "
                      "/opt/pyenv/3.11/bin/python -m pip install numpy; "
                      "apt-get install python3-numpy installs it only for /usr/bin/python3\n", other)


if __name__ == "__main__":
    tap_runner.main()
