#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of the package weir: models and pipelines with NumPy arrays, and error texts."""

import gc
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings

import tap_runner
from built_modules import has_engine

try:
    import numpy as np
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SCRIPTS = SOURCE / "src" / "modules" / "engines" / "python3"
MODEL = SOURCE / "models" / "clock_digits.onnx"
LOOP = "appsrc name=in ! {} ! tensor_sink name=out"


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.any = self.folder / "any.model"
        self.any.write_text("x")

    def script(self, text):
        path = self.folder / f"script{len(list(self.folder.iterdir()))}.py"
        path.write_text("import numpy as np\nfrom weir import TensorShape\n" + text)
        return path

    def error(self, call, *arguments, **more):
        with self.assertRaises(weir.Error) as raised:
            call(*arguments, **more)
        return raised.exception


class Models(Files):
    """The engine `fake` adds 1 to float32 (?, 4); `scaling` multiplies any length."""

    def test_a_model_describes_itself(self):
        with weir.Model(self.any, engine="fake") as model:
            self.assertEqual(model.engine, "fake")
            (x,), (y,) = model.inputs, model.outputs
            self.assertEqual((x.name, x.dtype, x.shape), ("x", np.float32, (None, 4)))
            self.assertEqual((y.name, y.scale, y.zero_point), ("y", 0, 0))
            self.assertIn("float32 (?, 4) x", repr(x))

    def test_arrays_go_in_and_come_out(self):
        model = weir.Model(str(self.any), engine="fake")
        x = np.arange(8, dtype=np.float32).reshape(2, 4)
        (y,) = model.invoke(x)
        np.testing.assert_array_equal(y, x + 1)
        np.testing.assert_array_equal(model.invoke([x[::-1]])[0], x[::-1] + 1, "views that are not dense")
        self.assertEqual(y.shape, (2, 4))
        self.assertFalse(y.flags.writeable)

    def test_outputs_outlive_their_model(self):
        model = weir.Model(self.any, engine="fake")
        (y,) = model.invoke(np.zeros((1, 4), np.float32))
        model.close()
        del model
        gc.collect()
        np.testing.assert_array_equal(y, np.ones((1, 4)))

    def test_shapes_can_be_set(self):
        model = weir.Model(self.any, engine="fake")
        model.reshape([(3, 4)])
        self.assertEqual(model.inputs[0].shape, (3, 4))
        self.assertEqual(model.outputs[0].shape, (3, 4))
        self.assertEqual(self.error(model.reshape, [(3, 5)]).code, weir.Code.SPEC_MISMATCH)

    def test_batches(self):
        model = weir.Model(self.any, engine="fake")
        frames = [np.full((1, 4), i, np.float32) for i in range(3)]
        for i, (y,) in enumerate(model.invoke_batch(frames)):
            np.testing.assert_array_equal(y, np.full((1, 4), i + 1))

    def test_options_and_dropped_frames(self):
        model = weir.Model(self.any, engine="scaling", options={"factor": 2.5})
        np.testing.assert_array_equal(model.invoke(np.array([2, 4], np.float32))[0], [5, 10])
        self.assertIsNone(weir.Model(self.any, engine="fake", options={"drop-at": 0}).invoke(np.zeros((1, 4), np.float32)))

    def test_errors_are_reported_in_parts(self):
        error = self.error(weir.Model, "/no/such/file.onnx", engine="fake")
        self.assertEqual(error.code, weir.Code.MODEL_NOT_FOUND)
        self.assertEqual(error.code, 3003)
        self.assertEqual(error.what, "the model file does not exist")
        self.assertEqual(error.offered, "/no/such/file.onnx")
        self.assertEqual(error.fix, "")
        self.assertIn("WEIR-3003: the model file does not exist\n  offered: /no/such/file.onnx", str(error))

    def test_wrong_arrays_are_named(self):
        model = weir.Model(self.any, engine="fake")
        error = self.error(model.invoke, np.zeros((1, 4)))
        self.assertEqual((error.code, error.offered, error.needed), (weir.Code.SPEC_MISMATCH, "float64", "float32"))
        self.assertIn("input 0 (x)", error.what)
        self.assertEqual(self.error(model.invoke, np.zeros((1, 5), np.float32)).code, weir.Code.SPEC_MISMATCH)
        self.assertIn("number of tensors", str(self.error(model.invoke, [])))
        for dtype in (">f4", complex, object, "U1", bool):
            self.assertEqual(self.error(model.invoke, np.zeros((1, 4), dtype)).code, weir.Code.TYPE_SYNTAX, dtype)
        with self.assertRaises(ValueError):
            weir.Model(self.any, engine="fake", timeout=-1)

    def test_a_closed_model_is_reported_as_closed(self):
        model = weir.Model(self.any, engine="fake")
        model.close()
        model.close()
        with self.assertRaisesRegex(ValueError, "the model is closed"):
            model.invoke(np.zeros((1, 4), np.float32))

    def test_threads_share_a_model(self):
        model, wrong = weir.Model(self.any, engine="fake"), []

        def work(i):
            x = np.full((1, 4), i, np.float32)
            wrong.extend(1 for _ in range(200) if not (model.invoke(x)[0] == i + 1).all())

        threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    @unittest.skipUnless(has_engine("onnxruntime"), "the engine onnxruntime is not built")
    def test_a_network(self):
        model = weir.Model(MODEL, threads=1)
        zeros = np.zeros([d or 1 for d in model.inputs[0].shape], np.float32)
        (scores,) = model.invoke(zeros)
        self.assertEqual(scores.dtype, np.float32)
        self.assertTrue(np.isfinite(scores).all())

    def test_a_script_is_a_model_in_the_same_interpreter(self):
        model = weir.Model(SCRIPTS / "average.py", options={"custom": "3 2 2"})
        self.assertEqual(model.inputs[0].shape, (1, 2, 2, 3))
        (mean,) = model.invoke(np.arange(12, dtype=np.uint8).reshape(1, 2, 2, 3))
        np.testing.assert_array_equal(mean, [4.5, 5.5, 6.5])
        (same,) = weir.Model(SCRIPTS / "passthrough.py").invoke(np.arange(3, dtype=np.int16))
        np.testing.assert_array_equal(same, [0, 1, 2])

    def test_a_script_that_fails_is_a_weir_error(self):
        path = self.script("class CustomFilter:\n  def setInputDim(self, dims): return dims\n"
                           "  def invoke(self, arrays): raise KeyError('lost')\n")
        error = self.error(weir.Model(path).invoke, np.zeros(1, np.uint8))
        self.assertEqual(error.what, "the script failed: KeyError: 'lost'")
        self.assertIn(f"{path}:5 in invoke", error.offered)


class Pipelines(Files):
    def test_frames_go_through(self):
        with weir.Pipeline(LOOP.format("tensor_transform mode=arithmetic option=mul:2,add:1")) as pipeline:
            self.assertEqual(pipeline.state, "playing")
            for i in range(3):
                pipeline.push("in", np.arange(4, dtype=np.float32) + i, pts=i * 10**8)
            pipeline.end("in")
            for i in range(3):
                frame = pipeline.pull("out", timeout=60)
                self.assertEqual((len(frame), frame.pts, frame.duration), (1, i * 10**8, None))
                np.testing.assert_array_equal(frame[0], (np.arange(4) + i) * 2 + 1)
            self.assertIsNone(pipeline.pull("out", timeout=60))
            self.assertTrue(pipeline.ended("out"))
            self.assertTrue(pipeline.wait(60))
        self.assertEqual(pipeline.state, "stopped")

    def test_frames_outlive_their_pipeline(self):
        pipeline = weir.Pipeline(LOOP.format("identity"))
        pipeline.start()
        pipeline.push("in", [np.array([1, 2], np.int32), np.array([3], np.uint8)])
        frame = pipeline.pull("out", 60)
        first, second = frame
        self.assertIn("other/tensors", frame.caps)
        pipeline.close()
        del pipeline, frame
        gc.collect()
        np.testing.assert_array_equal(first, [1, 2])
        np.testing.assert_array_equal(second, [3])
        self.assertFalse(first.flags.writeable)

    def test_a_function_gets_the_frames(self):
        pipeline, got = weir.Pipeline(LOOP.format("identity")), []
        pipeline.on_frame("out", lambda frame: got.append(frame[0].tolist()))
        with pipeline:
            for i in range(5):
                pipeline.push("in", np.array([i], np.uint8))
            pipeline.end("in")
            self.assertTrue(pipeline.wait(60))
        self.assertEqual(got, [[0], [1], [2], [3], [4]])

    def test_what_a_function_raises_ends_the_stream(self):
        pipeline = weir.Pipeline(LOOP.format("identity"))

        def fail(frame):
            raise RuntimeError("not this one")

        pipeline.on_frame("out", fail)
        with pipeline:
            pipeline.push("in", np.zeros(1, np.uint8))
            error = self.error(pipeline.wait, 60)
            self.assertEqual(error.code, weir.Code.CALLBACK_FAILED)
            self.assertIn("not this one", str(error))

    def test_a_function_cannot_stop_its_own_pipeline(self):
        pipeline = weir.Pipeline(LOOP.format("identity"))
        raised = []
        called = threading.Event()

        def stop(frame):
            for call in (pipeline.stop, pipeline.pause, pipeline.start):
                try:
                    call()
                except weir.Error as error:
                    raised.append(error)
            called.set()

        pipeline.on_frame("out", stop)
        pipeline.start()
        pipeline.push("in", np.zeros(4, np.float32))
        self.assertTrue(called.wait(60))
        self.assertEqual([error.code for error in raised], [weir.Code.CANCELLED] * 3)
        self.assertIn("a callback cannot change the state of its own pipeline", str(raised[0]))
        pipeline.stop()
        self.assertEqual(pipeline.state, "stopped")

    def test_a_function_may_close_its_own_pipeline(self):
        pipeline = weir.Pipeline(LOOP.format("identity"))
        frames = []
        pushed, closed = threading.Event(), threading.Event()

        def close(frame):
            pushed.wait(60)
            frames.append(frame)
            pipeline.close()
            closed.set()

        pipeline.on_frame("out", close)
        pipeline.start()
        for _ in range(5):
            pipeline.push("in", np.zeros(4, np.float32))
        pushed.set()
        self.assertTrue(closed.wait(60))
        with self.assertRaisesRegex(ValueError, "the pipeline is closed"):
            pipeline.stop()
        self.assertEqual(len(frames), 1)

    def test_properties(self):
        pipeline = weir.Pipeline(LOOP.format("identity name=i silent=true ! valve name=v"))
        self.assertEqual(pipeline.get("i", "silent"), "true")
        pipeline.set("i", "silent", False)
        self.assertEqual(pipeline.get("i", "silent"), "false")
        pipeline.set("i", "sleep-time", 7)
        self.assertEqual(pipeline.get("i", "sleep-time"), "7")
        pipeline.open_valve("v", False)
        self.assertEqual(pipeline.get("v", "drop"), "true")
        self.assertEqual(self.error(pipeline.set, "i", "silnt", True).code, weir.Code.OPTION_VALUE)

    def test_errors_are_reported(self):
        self.assertIn("did you mean tensor_filter?", str(self.error(weir.Pipeline, "tensor_filtre")))
        with weir.Pipeline(LOOP.format(f"tensor_filter framework=fake model={self.any}")) as pipeline:
            pipeline.push("in", np.zeros((1, 5), np.float32))
            error = self.error(pipeline.pull, "out", 60)
            self.assertEqual(error.code, weir.Code.SPEC_MISMATCH)

    def test_warnings_of_elements_are_warnings(self):
        with weir.Pipeline(LOOP.format(f"tensor_filter name=nn framework=fake model={self.any}")) as pipeline:
            with self.assertWarnsRegex(weir.PipelineWarning, "WEIR-1004: nn: the model takes effect at the next start") as caught:
                pipeline.set("nn", "model", "other.onnx")
            self.assertEqual(caught.filename, __file__)
            self.assertEqual(caught.warning.error.code, weir.Code.OPTION_VALUE)
            self.assertEqual(caught.warning.error.offered, "model=other.onnx")
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self.assertRaises(weir.PipelineWarning, pipeline.set, "nn", "model", "third.onnx")
                pipeline.get("nn", "model")  # each warning once
            with warnings.catch_warnings(record=True) as seen:
                self.assertEqual(self.error(pipeline.set, "nn", "modle", "x").code, weir.Code.OPTION_VALUE)
            self.assertEqual(seen, [])

    def test_a_value_that_an_element_rejects_is_an_error(self):
        with weir.Pipeline(LOOP.format(f"tensor_filter name=nn framework=fake is-updatable=true model={self.any}")) as pipeline:
            with warnings.catch_warnings(record=True) as seen:
                error = self.error(pipeline.set, "nn", "model", "nope.onnx")
            self.assertEqual((error.code, error.offered), (weir.Code.MODEL_NOT_FOUND, "nope.onnx"))
            self.assertEqual(pipeline.get("nn", "model"), str(self.any))
            self.assertEqual(seen, [])

    def test_a_script_of_the_pipeline_runs_in_the_same_interpreter(self):
        filters = f"tensor_filter model={SCRIPTS / 'passthrough.py'} ! queue ! tensor_filter model={SCRIPTS / 'passthrough.py'}"
        with weir.Pipeline(LOOP.format(filters)) as pipeline:
            for i in range(50):
                pipeline.push("in", np.full(1000, i, np.int64))
            for i in range(50):
                self.assertEqual(pipeline.pull("out", 60)[0][999], i)

    def test_a_forked_process_gets_errors_and_ends(self):
        program = ("import os, weir\n"
                   "p = weir.Pipeline('videotestsrc is-live=true ! tensor_converter ! tensor_sink name=out')\np.start()\np.pull('out', 60)\n"
                   "child = os.fork()\n"
                   "if child == 0:\n"
                   "    for call in (p.stop, p.wait, lambda: p.pull('out'), p.start, lambda: weir.Pipeline('videotestsrc ! fakesink')):\n"
                   "        try:\n            call()\n"
                   "        except weir.Error as error:\n            print(error.code.name, error.fix)\n"
                   "    raise SystemExit(3)\n"
                   "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), p.pull('out', 60) is not None)")
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(done.stdout, 5 * 'GRAPH_STALLS in Python: multiprocessing.get_context("spawn").Pool()\n' + "3 True\n", done.stderr)

    def test_a_program_may_end_while_its_pipeline_plays(self):
        program = ("import weir, numpy\n"
                   f"p = weir.Pipeline('videotestsrc is-live=true ! tensor_converter ! tensor_filter model={SCRIPTS}/passthrough.py"
                   " ! tensor_sink name=out')\n"
                   "p.on_frame('out', lambda frame: None)\np.start()\n"
                   "q = weir.Pipeline('videotestsrc ! tensor_converter ! tensor_sink name=out')\nq.start()\nq.pull('out', 60)\n"
                   "print('end')")
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, "end\n"), done.stderr)


class Shapes(unittest.TestCase):
    def test_scripts_and_programs_have_one_class(self):
        import nnstreamer_python
        self.assertIs(nnstreamer_python.TensorShape, weir.TensorShape)
        self.assertEqual(weir.TensorShape([2, 3]).dims, [2, 3] + [0] * 14)
        self.assertEqual(weir.TensorShape([1], float).getType(), np.float64)

    def test_a_shape_keeps_a_list_of_its_own(self):
        dims = [2, 3]
        shape, other = weir.TensorShape(dims), weir.TensorShape(dims, type=np.int8)
        dims.append(4)
        other.getDims()[0] = 9
        self.assertEqual(shape.getDims(), [2, 3] + [0] * 14)
        self.assertEqual(other.dims, [9, 3] + [0] * 14)
        self.assertEqual(dims, [2, 3, 4])

    def test_a_shape_of_nothing_is_zeros_of_uint8(self):
        self.assertEqual((weir.TensorShape().dims, weir.TensorShape().type), ([0] * 16, np.dtype("uint8")))
        for dims in ((1, 2), "12", {1}, 3):
            with self.assertRaisesRegex(TypeError, "dimensions of a TensorShape are a list, not"):
                weir.TensorShape(dims)
        with self.assertRaisesRegex(ValueError, "17 dimensions: a tensor has at most 16"):
            weir.TensorShape([1] * 17)


if __name__ == "__main__":
    tap_runner.main()
