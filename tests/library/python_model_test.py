#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of weir.Model as a function with outputs by name, and of its errors in Python's terms."""

import pathlib
import sys
import tempfile
import unittest

import tap_runner

try:
    import numpy as np
    import weir
    from weir.error import python_spelling
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

SCRIPT = """
import numpy as np
from weir import TensorShape

class CustomFilter:
    def getInputDim(self): return [TensorShape([2], np.float32), TensorShape([2], np.float32)]
    def getOutputDim(self): return [TensorShape([2], np.float32), TensorShape([2], np.float32)]
    def invoke(self, arrays): return [arrays[0] + arrays[1], arrays[0] - arrays[1]]
"""


class ModelCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "any.model"
        self.file.write_text("x")

    def fake(self, **more):
        return weir.Model(self.file, engine="fake", **more)  # adds 1 to the input x, float32 (?, 4): the output y

    def error(self, call, *arguments, **more):
        with self.assertRaises(weir.Error) as raised:
            call(*arguments, **more)
        return raised.exception


class Calls(ModelCase):
    def test_give_outputs_by_place_and_by_name(self):
        model, x = self.fake(), np.arange(4, dtype=np.float32).reshape(1, 4)
        for outputs in (model(x), model([x]), model((x,)), model({"x": x}), model(x=x), model.invoke(x), model.invoke({"x": x})):
            self.assertIsInstance(outputs, weir.Outputs)
            self.assertIsInstance(outputs, list)
            np.testing.assert_array_equal(outputs["y"], x + 1)
            self.assertIs(outputs["y"], outputs[0])
            self.assertEqual(outputs.names, ("y",))
            self.assertEqual(list(outputs.as_dict()), ["y"])
        self.assertEqual(repr(outputs), "<weir.Outputs y: float32 (1, 4)>")

    def test_take_several_inputs(self):
        path = self.folder / "sum.py"
        path.write_text(SCRIPT)
        model = weir.Model(path)
        a, b = np.array([5, 7], np.float32), np.array([1, 2], np.float32)
        for outputs in (model(a, b), model([a, b]), model.invoke((a, b))):
            total, difference = outputs
            self.assertEqual((total.tolist(), difference.tolist()), ([6, 9], [4, 5]))
        self.assertEqual(self.error(model, a).code, weir.Code.SPEC_MISMATCH)

    def test_of_batches_have_names_too(self):
        frames = [np.full((1, 4), i, np.float32) for i in range(2)]
        first, second = self.fake().invoke_batch([frames[0], {"x": frames[1]}])
        self.assertEqual((first["y"][0, 0], second["y"][0, 0]), (1, 2))

    def test_of_a_dropped_frame_give_none(self):
        self.assertIsNone(self.fake(options={"drop-at": 0})(np.zeros((1, 4), np.float32)))

    def test_names_that_are_wrong(self):
        model, x = self.fake(), np.zeros((1, 4), np.float32)
        with self.assertRaisesRegex(KeyError, "the model has no output 'z'; its outputs are 'y'"):
            model(x)["z"]
        with self.assertRaisesRegex(KeyError, "it has no input 'image'; the model's inputs are 'x'"):
            model(image=x)
        with self.assertRaisesRegex(KeyError, "the input 'x' is missing"):
            model({})
        with self.assertRaisesRegex(TypeError, "either in their order or by name"):
            model(x, x=x)

    def test_repr(self):
        model = self.fake()
        self.assertRegex(repr(model), r"^<weir.Model fake: float32 \(\?, 4\) x -> float32 \(\?, 4\) y>$")
        self.assertFalse(model.closed)
        model.close()
        self.assertEqual((repr(model), model.closed), ("<weir.Model closed>", True))


class Spelling(ModelCase):
    """What to do about an error is said in arguments of weir.Model, in str(error) too."""

    def test_of_the_path(self):
        (self.folder / "net.onnx").write_text("x")
        error = self.error(weir.Model, self.folder / "nett.onnx")
        self.assertEqual(error.fix, f'weir.Model("{self.folder}/net.onnx")')
        self.assertIn(f"fix: {error.fix}", str(error))

    def test_of_the_engine(self):
        error = self.error(weir.Model, self.file, engine="onnxruntim")
        self.assertEqual((error.code, error.offered), (weir.Code.ENGINE_UNKNOWN, 'engine="onnxruntim"'))
        self.assertRegex(error.fix, r'^engine="\w+"$')
        self.assertEqual(self.error(weir.Model, self.file).fix, 'name the engine: engine="onnxruntime"')

    def test_of_types_and_shapes(self):
        self.assertEqual(self.error(self.fake(), np.zeros((1, 4))).fix, "array.astype(numpy.float32)")
        self.assertEqual(self.error(self.fake().invoke_batch, [np.zeros((1, 4))]).fix, "array.astype(numpy.float32)")
        array = np.zeros((1,) * 16 + (4,), np.float32)
        for call in (self.fake(), lambda x: weir.Pipeline("appsrc name=in ! tensor_sink").push("in", x)):
            error = self.error(call, array)
            self.assertEqual((error.code, error.offered, error.needed), (weir.Code.LIMIT_EXCEEDED, "17 axes", "at most 16"))
            self.assertEqual(eval(error.fix, {"array": array}).ndim, 16)

    def test_of_each_property(self):
        for text, spelled in {
                "model=net.cfg,net.weights": 'weir.Model(["net.cfg", "net.weights"])',
                "framework=tensorflow-lite without Lowering": 'engine="tensorflow-lite" without Lowering',
                "custom=NumThreads:1": 'options={"NumThreads": "1"}',
                "accelerator=true:npu,gpu": 'accelerator="true:npu,gpu"',
                "inputtype=float32": 'declared={"inputtype": "float32"}',
                "model.reshape({{1, 4}, {3}})": "model.reshape([(1, 4), (3,)])",
                "tensor_transform mode=typecast option=float32 ! tensor_filter": "array.astype(numpy.float32)",
                "weir inspect MODEL": "weir inspect MODEL", "": ""}.items():
            self.assertEqual(python_spelling(text), spelled)

    def test_of_a_pipeline_is_that_of_gst_launch(self):
        pipeline = weir.Pipeline("appsrc name=in ! tensor_filter name=f framework=no-such-engine model=a.onnx ! tensor_sink name=out")
        error = self.error(pipeline.start)
        self.assertEqual((error.code, error.fix), (weir.Code.ENGINE_UNKNOWN, "framework=auto"))


if __name__ == "__main__":
    tap_runner.main()
