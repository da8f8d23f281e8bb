#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Classifies photos of ../shared in whole pipelines and compares with its reference results.

The reference pixels were scaled by another library, so scores differ slightly. If the reference's first
class leads clearly, ours must be the same; if two are close, the reference's first must be among our three.
"""

import json
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / ".." / "shared")
WEIR = os.environ["WEIR_COMMAND"]
RESULTS = SHARED / "media" / "reference_results.json"
ENGINES = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite"}
# The margin in units of the model's output with which a first class is clear.
CLEAR = {"uint8": 12, "float32 probability": 0.1, "float32 score": 1.0}
FORMATS = {"uint8": "B", "float32": "f"}


def missing():
    if not RESULTS.exists():
        return "the real models are not there"
    lacking = [engine for engine in ENGINES.values() if engine not in os.environ["WEIR_MODULE_PATH"]]
    return f"the engine {lacking[0]} is not built" if lacking else None


def inspect(model):
    done = subprocess.run([WEIR, "inspect", "--json", model], capture_output=True, text=True, check=True,
                          env={**os.environ, "WEIR_CARD_PATH": str(SOURCE / "models" / "cards")})
    return json.loads(done.stdout)


def play(photo, preparation, rest):
    line = f'filesrc location="{photo}" ! decodebin ! {preparation} ! {rest}'
    return subprocess.run(["bash", "-c", "exec gst-launch-1.0 -q " + line.replace(" ! ", " '!' ")], timeout=120,
                          capture_output=True, text=True, stdin=subprocess.DEVNULL)


@unittest.skipIf(missing(), missing())
class Classification(unittest.TestCase):
    def classify(self, photo, model, report):
        """The classes by descending score, and the output of image_labeling."""
        with tempfile.TemporaryDirectory() as folder:
            scores, text, labels = (pathlib.Path(folder) / name for name in ("scores", "text", "labels"))
            labels.write_text("\n".join(report["card"]["labels"]) + "\n")
            done = play(photo, report["card"]["preparation"],
                        f'tensor_filter model="{model}" ! tee name=t ! queue ! filesink location={scores} '
                        f"t. ! queue ! tensor_decoder mode=image_labeling option1={labels} ! filesink location={text}")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+")
            output = report["outputs"][0]
            values = [v for (v,) in struct.iter_unpack(FORMATS[output["type"]], scores.read_bytes())]
            label = text.read_bytes().rstrip(b"\0").decode()
        return sorted(range(len(values)), key=lambda i: -values[i]), label

    def test_photos_agree_with_the_reference(self):
        compared = 0
        models = {m.name: inspect(m) for m in sorted((SHARED / "models" / "classification").iterdir())
                  if m.suffix in ENGINES}
        for photo, by_model in json.loads(RESULTS.read_text())["classification"].items():
            for model, reference in by_model.items():
                with self.subTest(photo=photo, model=model):
                    report = models[model]
                    ours, label = self.classify(SHARED / "media" / "image" / photo,
                                                SHARED / "models" / "classification" / model, report)
                    kind = report["outputs"][0]["type"]
                    if kind == "float32":
                        kind += " probability" if reference[0][2] <= 1 else " score"
                    clear = reference[0][2] - reference[1][2] >= CLEAR[kind]
                    self.assertIn(reference[0][0], ours[:1] if clear else ours[:3])
                    self.assertEqual(label, report["card"]["labels"][ours[0]])
                    compared += 1
        self.assertGreaterEqual(compared, 20)

    def test_the_nine_is_read(self):
        model = SHARED / "models" / "classification" / "mnist.onnx"
        ours, label = self.classify(SHARED / "media" / "image" / "9.png", model, inspect(model))
        self.assertEqual((ours[0], label), (9, "9"))

    # MANIFEST: persons on bus and three_people, none on burger and cats_and_dogs.
    def test_persons_are_seen(self):
        model = SHARED / "models" / "classification" / "vww_96_int8.tflite"
        report = inspect(model)
        report["outputs"][0]["type"] = "uint8"  # avoids comparing int8 scores; only the label matters here
        for photo, label in (("image/bus.jpg", "person"), ("face/three_people.jpg", "person"),
                             ("image/burger.jpg", "no person"), ("image/cats_and_dogs.jpg", "no person")):
            self.assertEqual(self.classify(SHARED / "media" / photo, model, report)[1], label, photo)


@unittest.skipIf(missing(), missing())
class Demo(unittest.TestCase):
    def demo(self, source, model):
        return subprocess.run([SOURCE / "tools/demo", "--build", os.environ["WEIR_BUILD"], "--input", source, "--model",
                               model], timeout=120, capture_output=True, text=True, stdin=subprocess.DEVNULL,
                              env={**os.environ, "WEIR_DATA": str(SHARED)})

    def test_it_classifies_a_photo_found_by_name(self):
        done = self.demo("orange.png", "mobilenet_v2_1.0_224_quant.tflite")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("orange: 1 of 1 frames", done.stdout)

    def test_it_gives_a_card_to_fill_in(self):
        done = self.demo("orange.png", "zero_dce_lite.tflite")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-3008", done.stderr)
        self.assertIn('"sha256": "', done.stderr)

    def test_it_reports_what_is_missing(self):
        self.assertIn("nosuch.jpg is not there", self.demo("nosuch.jpg", "mnist.onnx").stderr)
        self.assertIn("nosuch.onnx is not there", self.demo("orange.png", "nosuch.onnx").stderr)


if __name__ == "__main__":
    tap_runner.main()
