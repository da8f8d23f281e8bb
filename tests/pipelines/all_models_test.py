#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs every model file of ../shared in a pipeline, or expects the rejection that is listed here."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
ENGINES = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite", ".pt": "pytorch", ".caffemodel": "caffe",
           ".pb": "tensorflow"}
REFUSED = {  # MANIFEST.md: state dicts, and models not run there because TensorFlow was missing
    "face/mtcnn/pnet.pt": "a state dict", "face/mtcnn/rnet.pt": "a state dict", "face/mtcnn/onet.pt": "a state dict",
    "tf/DS_CNN_S.pb": "wav_data", "audio/conv_actions_frozen.pb": "wav_data",
}
INPUTS = {  # for open inputs: dimensions and type of each
    "torchscript/pytorch_lenet5.pt": [("1:28:28:1", "uint8")],
    "torchscript/sample_3x4_two_input_two_output.pt": [("4:3", "float32")] * 2,
    "torchscript/sample_4x4x4x4x4_two_input_one_output.pt": [("4:4:4:4:4", "float32")] * 2,
    "face/mtcnn/torchscript/pnet.pt": [("40:30:3:1", "float32")],
    "face/mtcnn/torchscript/rnet.pt": [("24:24:3:1", "float32")],
    "face/mtcnn/torchscript/onet.pt": [("48:48:3:1", "float32")],
    "face/mtcnn/onnx/pnet.onnx": [("40:30:3:1", "float32")],
    "face/mtcnn/onnx_nhwc/pnet.onnx": [("3:40:30:1", "float32")],
    "face/mtcnn/onnx_nhwc/rnet.onnx": [("3:24:24:1", "float32")],
    "face/mtcnn/onnx_nhwc/onet.onnx": [("3:48:48:1", "float32")],
    "face/yunet_n_dynamic.onnx": [("64:64:3:1", "float32")],
}
VALUES = {("audio/conv_actions_frozen.tflite", 1): 16000}  # an int32 input that is not a signal: the sample rate
BYTES = {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "float16": 2, "int32": 4, "uint32": 4, "float32": 4,
         "int64": 8, "uint64": 8, "float64": 8}


def size(dimensions, kind):
    out = BYTES[kind]
    for extent in dimensions.split(":"):
        out *= int(extent)
    return out


def source(dimensions, kind, location="/dev/zero"):
    return (f"filesrc location={location} blocksize={size(dimensions, kind)} num-buffers=2 ! application/octet-stream ! "
            f"tensor_converter input-dim={dimensions} input-type={kind}")


def pipeline(model, name, inputs, folder):
    """Sends zeros into the model, twice."""
    inputs = [list(i) for i in inputs]
    for (of, index), value in VALUES.items():
        if of == name:
            path = pathlib.Path(folder) / "value.raw"
            path.write_bytes(value.to_bytes(4, "little") * 2)
            inputs[index].append(path)
    run = f"tensor_filter model={model} ! fakesink async=false"
    if len(inputs) == 1:
        return f"{source(*inputs[0])} ! {run}"
    return f"tensor_mux name=m ! {run}  " + "  ".join(f"{source(*i)} ! m.sink_{n}" for n, i in enumerate(inputs))


class AllModels(unittest.TestCase):
    def setUp(self):
        if not (SHARED / "models").is_dir():
            self.skipTest(f"{SHARED}/models is not there")

    def inspect(self, path):
        done = subprocess.run([os.environ["WEIR_COMMAND"], "inspect", "--json", path], capture_output=True, text=True,
                              timeout=120)
        return json.loads(done.stdout), done.returncode

    def inputs_of(self, described):
        def open_is_one(text):
            return ":".join("1" if part == "?" else part for part in text.split(":"))
        return [(open_is_one(i["dimension"]), i["type"]) for i in described["inputs"]]

    def test_each_runs_or_is_refused(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        seen, refused, ran = set(), 0, 0
        for path in sorted((SHARED / "models").rglob("*")):
            name = str(path.relative_to(SHARED / "models"))
            engine = ENGINES.get(path.suffix)
            if not engine or not has_engine(engine):
                continue
            seen.add(name)
            with self.subTest(model=name):
                described, code = self.inspect(path)
                if name in REFUSED:
                    self.assertNotEqual(code, 0)
                    self.assertIn(REFUSED[name], json.dumps(described))
                    refused += 1
                    continue
                self.assertEqual(code, 0, described)
                inputs = INPUTS.get(name) or self.inputs_of(described)
                done = subprocess.run(["gst-launch-1.0", "-q", *pipeline(path, name, inputs, folder.name).split()], capture_output=True,
                                      text=True, timeout=120)
                self.assertEqual(done.returncode, 0, done.stderr[-1500:])
                self.assertNotRegex(done.stderr, "CRITICAL|ERROR")
                ran += 1
        listed = {name for name in [*REFUSED, *INPUTS] if has_engine(ENGINES[pathlib.Path(name).suffix])}
        self.assertEqual(listed - seen, set(), "all that is listed is there")
        self.assertEqual(refused, len(listed & set(REFUSED)))
        self.assertGreater(ran, 3)


if __name__ == "__main__":
    tap_runner.main()
