#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads the outputs of real models with the modes of tensor_decoder and compares the results with the reference results."""

import json
import os
import subprocess
import unittest

import numpy

import tap_runner
from reference_models import EXACT, MODELS, PIXELS, SCORE, SOURCE, DetectionCase, planes, results, stretched
from built_modules import has_engine

COLUMNS = "x1,y1,x2,y2,score,class,track,parent,rotation"


class HeadCase(DetectionCase):
    def decode(self, model, pixels, mode, size, scale, *options):
        """The result tensors as arrays, outermost dimension first; `size`: height and width of the picture."""
        path = MODELS / model
        engine = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite"}[path.suffix]
        if not has_engine(engine):
            self.skipTest(f"the engine {engine} is not built")
        raw = self.folder / "input.raw"
        numpy.ascontiguousarray(pixels).tofile(raw)
        done = subprocess.run([os.environ["WEIR_DECODE_MODEL"], path, raw, mode, f"{size[1]}:{size[0]}",
                               f"{scale[0]:.9g}:{scale[1]:.9g}", *options], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        tables = [json.loads(line) for line in done.stdout.splitlines()]
        return {table["columns"]: numpy.array(table["numbers"]).reshape(table["shape"][::-1]) for table in tables}

    def labels(self, name):
        return (MODELS / "detection" / name).read_text().splitlines()


class Detection(HeadCase):
    def agree(self, rows, names, reference, sure, pixels=PIXELS):
        super().agree(numpy.array(names)[rows[:, 5].astype(int)], rows[:, 4], rows[:, :4], reference, sure, pixels)

    def of(self, photo, model, least):
        return [entry for entry in results()["detection"][photo][model] if entry[1] >= least]

    def photos(self):
        for photo in ("cats_and_dogs.jpg", "bus.jpg"):
            yield photo, results()["detection"][photo]["size"][:2]

    def test_ssd_with_its_own_choice_of_boxes(self):
        for photo, size in self.photos():
            with self.subTest(photo):
                pixels = stretched(self.picture(f"image/{photo}"), 300, 300)[None]
                rows = self.decode("detection/coco_ssd_mobilenet_v1_1.0_quant.tflite", pixels, "detection", size,
                                   (size[1] / 300, size[0] / 300), "threshold=0.45")[COLUMNS]
                self.agree(rows, self.labels("coco_labels_list.txt")[1:], self.of(photo, "coco_ssd_postprocess", 0.5), 0.55)

    def test_raw_ssd_with_the_usual_anchors_and_with_a_file(self):
        labels = MODELS / "detection/coco_labels_list.txt"
        for priors in ([], [f"priors={MODELS / 'detection/box_priors.txt'}"]):
            for photo, size in self.photos():
                with self.subTest(photo):
                    pixels = stretched(self.picture(f"image/{photo}"), 300, 300)[None]
                    rows = self.decode("detection/ssd_mobilenet_v1_raw_uint8.tflite", pixels, "detection", size,
                                       (size[1] / 300, size[0] / 300), "threshold=0.45", "iou=0.6", f"labels={labels}",
                                       *priors)[COLUMNS]
                    self.agree(rows, self.labels("coco_labels_list.txt"), self.of(photo, "ssd_raw_with_priors", 0.5), 0.6)

    def test_yolov5(self):
        for photo, size in self.photos():
            with self.subTest(photo):
                pixels = stretched(self.picture(f"image/{photo}"), 640, 640)[None]
                rows = self.decode("detection/yolov5n_uint8.tflite", pixels, "detection", size,
                                   (size[1] / 640, size[0] / 640))[COLUMNS]
                # Edges have steps of 1.5 times the scale, 7.5 px of 1200: 8 bits of the centre and half of the size.
                self.agree(rows, self.labels("coco-80.txt"), self.of(photo, "yolov5n_uint8(stretch 640)", 0.4), 0.6,
                           2 * 1.5 * 0.00419051 * max(size))

    def yolox(self, photo, size, model, *options):
        factor = 416 / max(size)
        height, width = (int(side * factor) for side in size)
        pixels = numpy.full((416, 416, 3), 114, "u1")
        pixels[:height, :width] = stretched(self.picture(f"image/{photo}", "BGR"), width, height)
        return self.decode(f"detection/{model}", planes(pixels), "detection", size, (1 / factor, 1 / factor), *options)[COLUMNS]

    def test_yolox(self):
        for photo, size in self.photos():
            with self.subTest(photo):
                self.agree(self.yolox(photo, size, "yolox_nano.onnx"), self.labels("coco-80.txt"),
                           self.of(photo, "yolox_nano.onnx(letterbox 416)", 0.5), 0.7, EXACT)

    def test_yolox_of_half_precision_finds_what_that_of_single_precision_finds(self):
        """Not checked in MANIFEST.md, so it is compared with the same network of single precision."""
        size = results()["detection"]["bus.jpg"]["size"][:2]
        single, half = (self.yolox("bus.jpg", size, model, "threshold=0.3")
                        for model in ("yolox_nano.onnx", "yolox_nano_float16.tflite"))
        self.assertEqual(single.shape, half.shape)
        self.assertLess(abs(single[:, :4] - half[:, :4]).max(), EXACT)
        self.assertLess(abs(single[:, 4] - half[:, 4]).max(), 0.02)
        self.assertEqual(single[:, 5].tolist(), half[:, 5].tolist())

    def test_fastestdet(self):
        size = results()["detection"]["bus.jpg"]["size"][:2]
        pixels = planes(stretched(self.picture("image/bus.jpg", "BGR"), 352, 352)) / numpy.float32(255)
        rows = self.decode("detection/FastestDet.onnx", pixels, "detection", size, (size[1] / 352, size[0] / 352))[COLUMNS]
        self.agree(rows, self.labels("coco-80.txt"), results("reference_results_extra")["FastestDet bus"], 0.75, EXACT)


class Classification(HeadCase):
    MEAN, DEVIATION = numpy.float32([0.485, 0.456, 0.406]), numpy.float32([0.229, 0.224, 0.225])
    # The references have the numbers of 8-bit outputs; of these, 256 or the softmax makes probabilities.
    MODELS = {"mobilenet_v2_1.0_224_quant.tflite": (224, "logits"), "mobilenet_v1_0.25_224_quant.tflite": (224, "parts"),
              "mobilenet_v1_0.75_192_quant.tflite": (192, "parts"), "mobilenet_v1_0.25_224_float.tflite": (224, "float"),
              "mobilenet_v2_quant.onnx": (224, "onnx")}

    CLEAR = {"logits": 12, "parts": 12, "float": 0.1, "onnx": 1}  # margins of a first class, as the references have scores

    def prepared(self, picture, side, kind):
        pixels = stretched(picture, side, side)
        if kind == "float":
            return ((pixels - numpy.float32(127.5)) / numpy.float32(127.5))[None]
        if kind == "onnx":
            return planes((pixels / numpy.float32(255) - self.MEAN) / self.DEVIATION)
        return pixels[None]

    def test_classes_are_those_of_the_references(self):
        for photo, models in results()["classification"].items():
            picture = self.picture(f"image/{photo}")
            for model, best in models.items():
                side, kind = self.MODELS[model]
                with self.subTest(f"{photo}, {model}"):
                    tables = self.decode(f"classification/{model}", self.prepared(picture, side, kind), "classification",
                                         picture.shape[:2], (1, 1), "threshold=0.0001", "max-results=3")
                    rows, scores = tables["score,class,track,parent"], tables["scores"]
                    self.assertGreater(len(rows), 0)
                    self.assertEqual(scores.shape, (len(rows), 1000 if kind == "onnx" else 1001))
                    numpy.testing.assert_allclose(scores[0][rows[:, 1].astype(int)], rows[:, 0])
                    if kind in ("logits", "onnx"):
                        self.assertAlmostEqual(scores[0].sum(), 1, places=4)
                    # Scores that are nearly equal may come in another order.
                    clear = best[0][2] - best[1][2] >= self.CLEAR[kind]
                    self.assertIn(best[0][0], rows[:1, 1] if clear else rows[:, 1])
                    if kind == "parts":
                        self.assertAlmostEqual(rows[0, 0], best[0][2] / 256, delta=SCORE)
                    if kind == "float":
                        self.assertAlmostEqual(rows[0, 0], best[0][2], delta=SCORE)
                    if kind == "logits":  # the difference of two logits is the logarithm of the quotient
                        of = scores[0][[best[0][0], best[1][0]]]
                        self.assertAlmostEqual(numpy.log(of[0] / of[1]), (best[0][2] - best[1][2]) * 0.0988925, delta=0.5)


    def test_a_nine_is_a_nine(self):
        pixels = planes(self.picture("image/9.png")[:, :, :1])
        rows = self.decode("classification/mnist.onnx", pixels, "classification", (28, 28), (1, 1))["score,class,track,parent"]
        self.assertEqual(rows[0, 1], 9)
        self.assertGreater(rows[0, 0], 0.9)

    def test_persons_are_seen_by_a_network_of_int8(self):
        for photo, is_person in (("image/bus.jpg", 1), ("face/three_people.jpg", 1), ("image/burger.jpg", 0)):
            with self.subTest(photo):
                picture = self.picture(photo)
                side, (height, width) = min(picture.shape[:2]), picture.shape[:2]
                square = picture[(height - side) // 2:][:side, (width - side) // 2:][:, :side]
                pixels = (stretched(square, 96, 96).astype("i2") - 128).astype("i1")[None]
                rows = self.decode("classification/vww_96_int8.tflite", pixels, "classification", (96, 96), (1, 1),
                                   "threshold=0")["score,class,track,parent"]
                self.assertEqual(rows[0, 1], is_person)
                self.assertAlmostEqual(rows[:, 0].sum(), 1, delta=0.02)


class Segmentation(HeadCase):
    def test_the_class_map_is_the_published_one(self):
        picture = self.picture("image/segmentation_input.jpg")
        pixels = ((stretched(picture, 257, 257) - numpy.float32(127.5)) / numpy.float32(127.5))[None]
        tables = self.decode("segmentation/deeplabv3_257_mv_gpu.tflite", pixels, "segmentation", picture.shape[:2],
                             (picture.shape[1] / 257, picture.shape[0] / 257))
        found = tables["class-map"]
        golden = self.picture("image/segmentation_golden.png")[:, :, 0] // 10
        self.assertEqual(found.shape, golden.shape)
        self.assertGreater((found == golden).mean(), 0.999)


class Documentation(unittest.TestCase):
    def test_each_head_has_a_row(self):
        text = (SOURCE / "docs/heads.md").read_text()
        rows = [line for line in text.splitlines() if line.startswith("| `")]
        names = subprocess.run([os.environ["WEIR_DECODE_MODEL"], "--heads"], capture_output=True, text=True, check=True).stdout
        for name, aliases, settings, threshold in (line.split("|") for line in names.splitlines()):
            row = next((row.split("|") for row in rows if row.startswith(f"| `{name}` |")), None)
            self.assertIsNotNone(row, f"docs/heads.md has no row for {name}")
            of = [", ".join(f"`{word}`" for word in words.split(",") if word) for words in (aliases, settings)]
            self.assertEqual([row[2].strip(), row[6].strip()], of, name)
            if row[7].strip():
                self.assertEqual(row[7].strip().split(",")[0], threshold, name)
            for setting in filter(None, settings.split(",")):
                self.assertIn(f"| `{setting}` |", text, f"the settings lack {setting}")


if __name__ == "__main__":
    tap_runner.main()
