#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares every scheme of tensor_decoder mode=bounding_boxes in whole pipelines with NumPy, byte for byte."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np

import bounding_boxes_reference as reference
import tap_runner
from built_modules import has_engine
from reference_models import LEAKED, MEDIA, MODELS, results

FRAMES, SECONDS = 4, 100
SIZE, OUTPUT = (96, 64), (200, 150)
RED = np.array([255, 0, 0, 255], np.uint8)


def spread(random, count, size=(0.02, 0.4)):
    """Centres and sizes of boxes, some beyond the edges."""
    return np.concatenate([random.uniform(-0.05, 1.05, (count, 2)), random.uniform(*size, (count, 2))], axis=1).astype("f4")


def sparse(random, shape, share=0.02):
    """Low scores with a few high ones."""
    scores = random.uniform(0, 0.2, shape)
    return np.where(random.random(shape) < share, random.uniform(0.2, 1, shape), scores).astype("f4")


class Schemes(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(7)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def labels(self, count):
        names = [f"class {i}" for i in range(count)]
        (self.folder / "labels.txt").write_text("\n".join(names) + "\n")
        return names, f"option2={self.folder / 'labels.txt'}"

    def frames(self, tensors, options):
        """Plays frames of tensors (arrays whose first axis is time) through the decoder."""
        data = b"".join(t[i].tobytes() for i in range(FRAMES) for t in tensors)
        (self.folder / "in").write_bytes(data)
        dims = ",".join(":".join(str(n) for n in reversed(t.shape[1:])) for t in tensors)
        line = (f"filesrc location={self.folder / 'in'} blocksize={len(data) // FRAMES} ! "
                f"application/octet-stream,framerate=10/1 ! tensor_converter input-dim={dims} "
                f"input-type={','.join(str(t.dtype) for t in tensors)} ! tensor_decoder mode=bounding_boxes {options} "
                f"option4={OUTPUT[0]}:{OUTPUT[1]} option5={SIZE[0]}:{SIZE[1]} ! filesink location={self.folder / 'out'}")
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotRegex(done.stderr, LEAKED)
        return np.frombuffer((self.folder / "out").read_bytes(), np.uint8).reshape(FRAMES, OUTPUT[1], OUTPUT[0], 4)

    def compare(self, tensors, options, boxes_of, labels=None, tracks=False):
        drawn, tracker, count = self.frames(tensors, options), reference.Tracker(), 0
        for i in range(FRAMES):
            boxes = boxes_of(*(t[i] for t in tensors))
            count += len(boxes)
            numbers = tracker.follow(boxes) if tracks else None
            wanted, cells = reference.draw(boxes, OUTPUT, SIZE, labels, numbers)
            np.testing.assert_array_equal(drawn[i][~cells], wanted[~cells])
            text = drawn[i][cells].reshape(-1, 4)
            self.assertTrue(((text == RED).all(axis=1) | (text == 0).all(axis=1)).all())
            self.assertEqual((text == RED).all(axis=1).any(), bool(labels and cells.any()))
        self.assertGreater(count, 2 * FRAMES, "the test has boxes to draw")

    def test_mobilenet_ssd(self):
        anchors, classes = 150, 4
        names, option2 = self.labels(classes)
        priors = np.concatenate([self.random.uniform(0, 1, (2, anchors)), self.random.uniform(0.1, 0.4, (2, anchors))]).astype("f4")
        (self.folder / "priors.txt").write_text("\n".join(", ".join(f"{v:.9g}" for v in row) for row in priors))
        boxes = self.random.normal(0, 1, (FRAMES, anchors, 1, 4)).astype("f4")
        scores = self.random.normal(-3, 2, (FRAMES, anchors, classes)).astype("f4")
        self.compare([boxes, scores], f"option1=mobilenet-ssd {option2} option3={self.folder / 'priors.txt'}",
                     lambda b, s: reference.mobilenet_ssd(b, s, priors, SIZE), names)
        self.compare([boxes, scores], f"option3={self.folder / 'priors.txt'}:0.3:8:9::4:0.2 {option2} option1=tflite-ssd",
                     lambda b, s: reference.mobilenet_ssd(b, s, priors, SIZE, 0.3, (8, 9, 5, 4), 0.2), names)

    def test_mobilenet_ssd_postprocess(self):
        rows = 10
        names, option2 = self.labels(3)
        first = self.random.uniform(-0.1, 0.8, (FRAMES, rows, 2))
        boxes = np.concatenate([first, first + self.random.uniform(0.05, 0.5, first.shape)], axis=2).astype("f4")
        classes = self.random.integers(0, 4, (FRAMES, rows)).astype("f4")  # 3 has no label
        scores = self.random.uniform(0, 1, (FRAMES, rows)).astype("f4")
        count = np.array([[10], [7], [4], [10]], "f4")
        self.compare([boxes, classes, scores, count], f"option1=mobilenet-ssd-postprocess option3=0:1:2:3,40 {option2}",
                     lambda b, c, s, n: reference.postprocessed(b, c, s, n[0], SIZE, 0.4), names)
        self.compare([count, classes, scores, boxes], "option1=tf-ssd",
                     lambda n, c, s, b: reference.postprocessed(b, c, s, n[0], SIZE, 1e-37))

    def test_openvino(self):
        records = np.zeros((FRAMES, 200, 7), "f4")
        records[:, :, 2] = self.random.uniform(0.7, 0.9, (FRAMES, 200))
        records[:, :, 3:5] = self.random.uniform(0, 0.7, (FRAMES, 200, 2))
        records[:, :, 5:] = records[:, :, 3:5] + self.random.uniform(0.01, 0.3, (FRAMES, 200, 2))
        records[:, 20:, 0] = -1
        for scheme in ("ov-person-detection", "ov-face-detection"):
            self.compare([records], f"option1={scheme}", lambda r: reference.openvino(r, SIZE))
        self.assertFalse(self.frames([records], f"option1=ov-person-detection {self.labels(2)[1]}").any(), "boxes have no class")

    def test_yolov5(self):
        names, option2 = self.labels(5)
        count = 3 * (3 * 2 + 6 * 4 + 12 * 8)
        rows = np.concatenate([spread(self.random, FRAMES * count), sparse(self.random, (FRAMES * count, 1), 0.2),
                               sparse(self.random, (FRAMES * count, 5), 0.2)], axis=1).reshape(FRAMES, count, 10)
        self.compare([rows], f"option1=yolov5 {option2}", lambda r: reference.yolo(r, SIZE, 5, False, 0.25, 0.45), names)
        rows[:, :, :4] *= 90
        self.compare([rows], f"option1=yolov5 {option2} option3=1:0.5:0.3", lambda r: reference.yolo(r, SIZE, 5, True, 0.5, 0.3), names)

    def test_yolov8(self):
        names, option2 = self.labels(5)
        count = 3 * 2 + 6 * 4 + 12 * 8
        rows = np.concatenate([spread(self.random, FRAMES * count), sparse(self.random, (FRAMES * count, 5))],
                              axis=1).reshape(FRAMES, count, 9)
        self.compare([rows], f"option1=yolov8 {option2} option6=1", lambda r: reference.yolo(r, SIZE, 4, False, 0.25, 0.45), names, True)

    def test_yolov8_obb(self):
        _, option2 = self.labels(3)
        count = 3 * 2 + 6 * 4 + 12 * 8
        rows = np.concatenate([spread(self.random, FRAMES * count, (0.1, 0.5)), sparse(self.random, (FRAMES * count, 3), 0.3),
                               self.random.uniform(0.01, 3, (FRAMES * count, 1)).astype("f4")], axis=1).reshape(FRAMES, count, 8)
        self.compare([rows], f"option1=yolov8-obb {option2} option3=0:0.3:0.2", lambda r: reference.yolo_obb(r, SIZE, 0.3, 0.2))

    def test_yolov10(self):
        names, option2 = self.labels(4)
        first = self.random.uniform(-0.1, 0.8, (FRAMES, 30, 2))
        rows = np.concatenate([first, first + self.random.uniform(0.05, 0.5, first.shape),
                               -np.sort(-self.random.uniform(0, 1, (FRAMES, 30, 1)), axis=1),
                               self.random.integers(0, 5, (FRAMES, 30, 1))], axis=2).astype("f4")  # 4 has no label
        self.compare([rows], f"option1=yolov10 {option2}", lambda r: reference.yolov10(r, SIZE, 0.25), names)
        self.compare([rows], "option1=yolov10 option3=0:0.8", lambda r: reference.yolov10(r, SIZE, 0.8))

    def test_mp_palm_detection(self):
        def heads(count):
            boxes = self.random.normal(0, 8, (FRAMES, count, 18)).astype("f4")
            boxes[:, :, 2:4] = self.random.uniform(4, 30, (FRAMES, count, 2))
            return [boxes, self.random.normal(-6, 3, (FRAMES, count, 1)).astype("f4")]
        usual = reference.palm_anchors()
        self.compare(heads(2016), "option1=mp-palm-detection option3=0.5", lambda b, s: reference.palms(b, s, usual, SIZE))
        other = reference.palm_anchors((16, 16, 32), 0.5, 0.9, (0.25, 0.75))
        self.compare(heads(len(other)), "option1=mp-palm-detection option3=0.3:3:0.5:0.9:0.25:0.75:16:16:32",
                     lambda b, s: reference.palms(b, s, other, SIZE, 0.3))


@unittest.skipUnless(MODELS.exists(), "the models beside this project (../shared) are not here")
@unittest.skipUnless(has_engine("tensorflow-lite"), "this build has no tensorflow-lite")
class RealModels(unittest.TestCase):
    """cats_and_dogs.jpg; MANIFEST.md: up to 10 px off by the resampler, and a step of the model's input is 4 px wide."""

    PIXELS = 14
    PICTURE = (1200, 600)

    def found(self, size, decoder, before="tensor_filter", after=""):
        model = f"{before} framework=tensorflow-lite model={MODELS / 'detection'}/"
        line = (f"filesrc location={MEDIA / 'image' / 'cats_and_dogs.jpg'} ! gdkpixbufdec ! videoconvert ! "
                f"videoscale method=bilinear add-borders=false ! video/x-raw,format=RGB,width={size},height={size} ! "
                f"tensor_converter ! {model}{decoder} option4=1200:600 option5={size}:{size} option7=1 ! fakesink {after}")
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              env=self.environment(), stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        boxes = re.findall(r"\[([\w ]+)\] x:(-?\d+) y:(-?\d+) w:(\d+) h:(\d+) prob:([\d.]+)", done.stdout + done.stderr)
        scale = np.array(self.PICTURE) / size
        return [(name, float(p), np.array([int(x), int(y), int(x) + int(w), int(y) + int(h)]) * np.tile(scale, 2))
                for name, x, y, w, h, p in boxes]

    @staticmethod
    def environment():
        return os.environ | {"GST_DEBUG": "weir-bounding_boxes:4", "GST_DEBUG_NO_COLOR": "1"}

    def agree(self, found, scheme, least):
        """Every published box above `least`, with its class and score."""
        published = [entry for entry in results()["detection"]["cats_and_dogs.jpg"][scheme] if entry[1] > least]
        self.assertGreater(len(published), 1)
        for name, score, box in published:
            near = [f for f in found if f[0] == name and abs(f[2] - box).max() <= self.PIXELS]
            self.assertTrue(near, f"{name} at {box} in {found}")
            self.assertLess(abs(near[0][1] - score), 0.05)

    def test_ssd_with_its_postprocessing(self):
        with tempfile.TemporaryDirectory() as folder:
            labels = pathlib.Path(folder) / "labels.txt"  # this model has no background
            labels.write_text("".join((MODELS / "detection" / "coco_labels_list.txt").read_text().splitlines(True)[1:]))
            self.agree(self.found(300, "coco_ssd_mobilenet_v1_1.0_quant.tflite ! tensor_decoder mode=bounding_boxes "
                                  f"option1=mobilenet-ssd-postprocess option2={labels} option3=0:1:2:3,40"),
                       "coco_ssd_postprocess", 0.44)

    def test_ssd_with_prior_boxes(self):
        folder = MODELS / "detection"
        scaled = ("d.src_0 ! queue ! tensor_transform mode=arithmetic option=typecast:float32,add:-191,mul:0.0790279 ! m.sink_0 "
                  "d.src_1 ! queue ! tensor_transform mode=arithmetic option=typecast:float32,add:-223,mul:0.0497368 ! m.sink_1")
        self.agree(self.found(300, "ssd_mobilenet_v1_raw_uint8.tflite ! tensor_demux name=d tensor_mux name=m ! "
                              f"tensor_decoder mode=bounding_boxes option1=mobilenet-ssd option2={folder / 'coco_labels_list.txt'} "
                              f"option3={folder / 'box_priors.txt'}:0.4", after=scaled), "ssd_raw_with_priors", 0.44)

    def test_yolov5(self):
        self.agree(self.found(640, "yolov5n_uint8.tflite ! tensor_transform mode=arithmetic "
                              "option=typecast:float32,mul:0.00419051 ! tensor_decoder mode=bounding_boxes option1=yolov5 "
                              f"option2={MODELS / 'detection' / 'coco-80.txt'} option3=0:0.3:0.5"),
                   "yolov5n_uint8(stretch 640)", 0.4)


if __name__ == "__main__":
    tap_runner.main()
