#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs every gst-launch-1.0 line of every README; none may leak a GStreamer object.

A line that names a model as `weir models get` or examples/mtcnn/fetch stores it, or a model that stands for the reader's own, runs
the test data's copy. All else is unchanged.
"""

import ctypes.util
import importlib.util
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

import mqtt_broker
import tap_runner
from built_modules import has_engine, has_module

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
SECONDS = 120
# pasted_test.py runs them with an installed tree, examples have tests of their own.
RUN_ELSEWHERE = ("README.md", "examples/",
                 *(f"docs/guide/{page}.md" for page in ("a-buffers-way", "classify-sound", "detect-objects", "first-pipeline",
                                                        "from-dlstreamer", "from-mediapipe", "offload", "use-a-sensor")))
BROKER_PORT = 1883  # of the lines
LEAKED = r"object-alive, type-name=\(string\)\w+"  # printed at the end by the leaks tracer of the environment
LEAKING = "objectdetectionoverlay"  # of GStreamer 1.26: what it drew last
ENGINES = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite",
           ".pt ": "pytorch", ".caffemodel": "caffe", ".pb ": "tensorflow", ".weights": "darknet"}


def documents():
    """What users read, of this project only."""
    yield from sorted(SOURCE.glob("*.md"))
    for folder in ("src", "models", "apps", "docs", "examples", "bindings", "packages"):
        yield from sorted((SOURCE / folder).rglob("*.md"))


def commands(text):
    """The gst-launch-1.0 and printf commands, those that set a tracer, and scripts that write a file, in ```sh blocks; a backslash continues a line."""
    inside, command = False, ""
    for line in text.splitlines():
        if line.startswith("```"):
            inside, command = line.startswith("```sh"), ""
        elif inside:
            command += line.strip()
            if command.endswith("\\"):
                command = command[:-1]
            else:
                if re.match(r"gst-launch-1\.0 |printf |GST_TRACERS=|python3 -c .* > /tmp/", command):
                    yield command
                command = ""


def models_of_readers():
    """The path of each model that a reader fetches or has, as the lines name it, and its place in the test data."""
    copies = {path.name: path for path in (SHARED / "models").rglob("*")}
    for model in json.loads((SOURCE / "models/catalogue.json").read_text())["models"]:
        for file in model["files"]:
            yield f"{model['name']}/{file['name']}", copies.get(file["name"], SHARED / "models" / file["name"])
    yield "blazeface/face_detection_short_range.tflite", SHARED / "models/face/blazeface_short_range.tflite"
    yield "onet.onnx", SHARED / "models/face/mtcnn/onnx_nhwc/onet.onnx"
    yield "lenet5.pt", SHARED / "models/torchscript/pytorch_lenet5.pt"
    yield "rnet.pt", SHARED / "models/face/mtcnn/torchscript/rnet.pt"
    yield "det2.prototxt", SHARED / "models/face/mtcnn/caffe/det2.prototxt"
    yield "det2.caffemodel", SHARED / "models/face/mtcnn/caffe/det2.caffemodel"
    yield "mnist.pb", SHARED / "models/tf/mnist.pb"


def with_copies(command):
    """The command with the test data's copies of the reader's models; a model may be files with commas between them."""
    copies = dict(models_of_readers())

    def copy(found):
        return "model=" + ",".join(str(copies.get(file, file)) for file in found[1].split(","))

    return re.sub(r"\bmodel=(\S+)", copy, command)


def missing(command):
    """What the command needs but this build or machine lacks; otherwise nothing."""
    for model in re.findall(r"\bmodel=(\S+)", command):
        for file in map(pathlib.Path, model.split(",")):
            if file.is_relative_to(SHARED) and not file.exists():
                return str(file)
    if re.search(r"mqttsink|mqttsrc|connect-type", command) and not mqtt_broker.find_mosquitto():
        return "mosquitto, an MQTT broker"
    for extension, engine in ENGINES.items():
        if extension in command and not has_engine(engine):
            return f"the engine {engine}"
    for name in re.findall(r"tensor_decoder mode=(protobuf|flatbuf|flexbuf)", command):
        if not has_module("decoder", name):
            return f"the library of {name}, when this was built"
    if (".lua" in command or "framework=lua" in command) and not ctypes.util.find_library("luajit-5.1"):
        return "LuaJIT"
    if "tensor_overlay" in command and "labels=" in command and os.environ["WEIR_TEXT"] != "true":
        return "Pango, when this was built"
    if "objectdetectionoverlay" in command and subprocess.run(["gst-inspect-1.0", "--exists", "objectdetectionoverlay"], check=False).returncode != 0:
        return "objectdetectionoverlay of GStreamer 1.24 or later"
    if ".py" in command and not (ctypes.util.find_library("python%d.%d" % sys.version_info[:2]) and importlib.util.find_spec("numpy")):
        return "Python as a library, or NumPy"
    return None


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if mqtt_broker.find_mosquitto() and not mqtt_broker.accepts_connections(BROKER_PORT):
            cls.enterClassContext(mqtt_broker.running_broker(BROKER_PORT))

    def test_blocks_are_read(self):
        text = "gst-launch-1.0 no\n```sh\nls\ngst-launch-1.0 a ! \\\n  b\n```\n```\ngst-launch-1.0 no\n```\n"
        self.assertEqual(list(commands(text)), ["gst-launch-1.0 a ! b"])

    def test_only_models_of_readers_are_replaced(self):
        name = "mobilenet-v2-quant/mobilenet_v2_1.0_224_quant.tflite"
        replaced = with_copies(f"a model={name} ! b")
        self.assertTrue(replaced.startswith(f"a model={SHARED}"), replaced)
        self.assertTrue(replaced.endswith("/mobilenet_v2_1.0_224_quant.tflite ! b"), replaced)
        self.assertEqual(with_copies("model=det2.prototxt,mine.caffemodel ! b"),
                         f"model={SHARED}/models/face/mtcnn/caffe/det2.prototxt,mine.caffemodel ! b")
        for other in ("mobilenet-v2-quant/other.tflite", "mobilenet_v2_1.0_224_quant.tflite", "README.md", "a/onet.onnx"):
            self.assertEqual(with_copies(f"model={other} ! b"), f"model={other} ! b")

    def test_a_leak_would_be_seen(self):
        leaking = ("import ctypes, ctypes.util; gst = ctypes.CDLL('libgstreamer-1.0.so.0'); gst.gst_init(None, None);"
                   "gst.gst_bin_new.restype = ctypes.c_void_p; gst.gst_bin_new(b'kept'); gst.gst_deinit()")
        # Without the plug-in: a Python without sanitizers cannot load it if this build uses them.
        env = os.environ | {"GST_PLUGIN_PATH": "", "GST_REGISTRY": os.environ["GST_REGISTRY"] + ".leak"}
        done = subprocess.run(["/usr/bin/python3", "-c", leaking], env=env, capture_output=True, text=True, timeout=SECONDS)
        self.assertIn("object-alive, type-name=(string)GstBin", re.findall(LEAKED, done.stderr))

    @unittest.skipUnless(os.environ.get("WEIR_SANITIZED"), "this build has no sanitizers")
    def test_a_memory_fault_fails_the_pipeline(self):
        command = ("gst-launch-1.0 videotestsrc num-buffers=1 ! video/x-raw,format=GRAY8 ! tensor_converter ! "
                   "tensor_filter framework=unruly model=README.md custom=open:overflow ! fakesink")
        done = subprocess.run(["bash", "-c", command], cwd=SOURCE, timeout=SECONDS, text=True, capture_output=True)
        self.assertNotEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("heap-buffer-overflow", done.stderr)

    def test_each_command_runs(self):
        count = 0
        for document in documents():
            if str(document.relative_to(SOURCE)).startswith(RUN_ELSEWHERE):
                continue
            for command in map(with_copies, commands(document.read_text())):
                count += 1
                with self.subTest(document=str(document.relative_to(SOURCE)), command=command):
                    if lacks := missing(command):
                        print(f"skipped, for {lacks} is not here: {command}", file=sys.stderr)
                        continue
                    env = os.environ | ({"GST_TRACERS": ""} if LEAKING in command else {})
                    done = subprocess.run(["bash", "-c", command], cwd=SOURCE, timeout=SECONDS, text=True, env=env,
                                          capture_output=True, stdin=subprocess.DEVNULL)
                    output = done.stdout + done.stderr
                    self.assertEqual(done.returncode, 0, output)
                    self.assertEqual(re.findall(LEAKED, output), [], command)
                    for word in ("CRITICAL", "WARNING", "ERROR", "runtime error"):
                        self.assertNotIn(word, output)
        self.assertGreater(count, 5, "the READMEs have pipelines")

    def test_no_document_names_the_test_data(self):
        """A reader has no such folder."""
        self.assertEqual([str(document.relative_to(SOURCE)) for document in documents() if "../shared" in document.read_text()], [])


if __name__ == "__main__":
    tap_runner.main()
