#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of weir.Error and weir.PipelineWarning: how they look, where they come from, and which goes first."""

import contextlib
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
import warnings

import tap_runner

try:
    import numpy as np
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

LOOP = "appsrc name=in ! tensor_sink name=out"
# Two warnings at each start, and one frame.
WARNS = ("videotestsrc num-buffers=1 ! tensor_converter ! tensor_rate framerate=none ! tensor_rate framerate=none ! "
         "tensor_sink name=out")
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


class RaisedWarnings(unittest.TestCase):
    """Warnings as exceptions: a call raises the first one that no call has raised yet."""

    def setUp(self):
        filters = contextlib.ExitStack()
        self.addCleanup(filters.close)
        filters.enter_context(warnings.catch_warnings())
        warnings.simplefilter("error", weir.PipelineWarning)
        self.pipeline = weir.Pipeline(WARNS)
        self.addCleanup(self.pipeline.close)

    def start(self):
        """The second warning waits for the next call."""
        self.assertRaises(weir.PipelineWarning, self.pipeline.start)
        self.assertEqual(self.pipeline.state, "playing")

    def test_a_block_that_is_not_entered_leaves_the_pipeline_stopped(self):
        with self.assertRaises(weir.PipelineWarning):
            with self.pipeline:
                self.fail("the block was entered")
        self.assertEqual(self.pipeline.state, "stopped")

    def test_no_frame_is_lost(self):
        self.start()
        self.assertRaises(weir.PipelineWarning, self.pipeline.pull, "out", 60)
        self.assertEqual(len(self.pipeline.pull("out", 60)), 1)
        self.assertIsNone(self.pipeline.pull("out", 60))

    def test_an_error_goes_first(self):
        self.start()
        self.assertEqual(error_of(self.pipeline.get, "out", "no-such-property").code, weir.Code.OPTION_VALUE)
        self.assertRaises(weir.PipelineWarning, self.pipeline.get, "out", "sync")

    def test_the_exception_of_a_block_goes_first(self):
        self.start()
        with self.assertRaises(KeyError), contextlib.ExitStack() as block:
            block.push(self.pipeline)  # does not start it again
            raise KeyError("not hidden")
        self.assertEqual(self.pipeline.state, "stopped")

    def test_stop_raises_when_it_has_stopped(self):
        self.start()
        self.assertRaises(weir.PipelineWarning, self.pipeline.stop)
        self.assertEqual(self.pipeline.state, "stopped")


class ShownWarnings(unittest.TestCase):
    def lines(self, use):
        """The line in this file of each warning, counted from the first line of the function `use`."""
        with warnings.catch_warnings(record=True) as seen:
            warnings.simplefilter("always")
            use(weir.Pipeline(WARNS))
        self.assertEqual({warning.filename for warning in seen}, {__file__})
        return [warning.lineno - use.__code__.co_firstlineno for warning in seen]

    def test_name_the_line_that_iterates(self):
        def use(pipeline):
            for frame in pipeline.frames("out", timeout=60):
                self.assertEqual(len(frame), 1)

        self.assertEqual(self.lines(use), [1, 1])

    def test_name_the_line_of_a_block(self):
        def use(pipeline):
            with pipeline:
                pipeline.wait(60)

        self.assertEqual(self.lines(use), [1, 1])


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
