#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares every scheme of tensor_decoder mode=bounding_boxes in whole pipelines with NumPy, byte for byte."""

import os
import re
import subprocess
import unittest

import numpy as np

import bounding_boxes_reference as reference
import tap_runner
from built_modules import has_engine
from decoder_case import SECONDS, DecoderCase
from drawing_reference import RED, Glyphs
from reference_models import MEDIA, MODELS, overlap, results, size_of

FRAMES = 4
SIZE, OUTPUT = (96, 64), (200, 150)


def spread(random, count, size=(0.02, 0.4)):
    """Centres and sizes of boxes, some beyond the edges."""
    return np.concatenate([random.uniform(-0.05, 1.05, (count, 2)), random.uniform(*size, (count, 2))], axis=1).astype("f4")


def sparse(random, shape, share=0.02):
    """Low scores with a few high ones."""
    scores = random.uniform(0, 0.2, shape)
    return np.where(random.random(shape) < share, random.uniform(0.2, 1, shape), scores).astype("f4")


class Schemes(DecoderCase):
    def frames(self, tensors, options):
        return self.pictures(tensors, f"mode=bounding_boxes {options} option4={OUTPUT[0]}:{OUTPUT[1]} option5={SIZE[0]}:{SIZE[1]}",
                             OUTPUT)

    def compare(self, tensors, options, boxes_of, labels=None, tracks=False):
        drawn, tracker, count, glyphs = self.frames(tensors, options), reference.Tracker(), 0, Glyphs(RED)
        for i in range(FRAMES):
            boxes = boxes_of(*(t[i] for t in tensors))
            count += len(boxes)
            numbers = tracker.follow(boxes) if tracks else None
            glyphs.compare(drawn[i], reference.draw(boxes, OUTPUT, SIZE, labels, numbers))
        self.assertGreater(count, 2 * FRAMES, "the test has boxes to draw")
        glyphs.check(5 if labels else 0)

    def numbered_labels(self, count):
        names = [f"class {i}" for i in range(count)]
        return names, self.labels(names)

    def test_mobilenet_ssd(self):
        anchors, classes = 150, 4
        names, option2 = self.numbered_labels(classes)
        priors, path = self.priors(anchors)
        boxes = self.random.normal(0, 1, (FRAMES, anchors, 1, 4)).astype("f4")
        scores = self.random.normal(-3, 2, (FRAMES, anchors, classes)).astype("f4")
        self.compare([boxes, scores], f"option1=mobilenet-ssd {option2} option3={path}",
                     lambda b, s: reference.mobilenet_ssd(b, s, priors, SIZE), names)
        self.compare([boxes, scores], f"option3={path}:0.3:8:9::4:0.2 {option2} option1=tflite-ssd",
                     lambda b, s: reference.mobilenet_ssd(b, s, priors, SIZE, 0.3, (8, 9, 5, 4), 0.2), names)

    def test_mobilenet_ssd_postprocess(self):
        rows = 10
        names, option2 = self.numbered_labels(3)
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
        self.assertFalse(self.frames([records], f"option1=ov-person-detection {self.numbered_labels(2)[1]}").any(), "boxes have no class")

    def test_yolov5(self):
        names, option2 = self.numbered_labels(5)
        count = 3 * (3 * 2 + 6 * 4 + 12 * 8)
        rows = np.concatenate([spread(self.random, FRAMES * count), sparse(self.random, (FRAMES * count, 1), 0.2),
                               sparse(self.random, (FRAMES * count, 5), 0.2)], axis=1).reshape(FRAMES, count, 10)
        self.compare([rows], f"option1=yolov5 {option2}", lambda r: reference.yolo(r, SIZE, 5, False, 0.25, 0.45), names)
        rows[:, :, :4] *= 90
        self.compare([rows], f"option1=yolov5 {option2} option3=1:0.5:0.3", lambda r: reference.yolo(r, SIZE, 5, True, 0.5, 0.3), names)

    def test_yolov8(self):
        names, option2 = self.numbered_labels(5)
        count = 3 * 2 + 6 * 4 + 12 * 8
        rows = np.concatenate([spread(self.random, FRAMES * count), sparse(self.random, (FRAMES * count, 5))],
                              axis=1).reshape(FRAMES, count, 9)
        self.compare([rows], f"option1=yolov8 {option2} option6=1", lambda r: reference.yolo(r, SIZE, 4, False, 0.25, 0.45), names, True)

    def test_yolov8_obb(self):
        _, option2 = self.numbered_labels(3)
        count = 3 * 2 + 6 * 4 + 12 * 8
        rows = np.concatenate([spread(self.random, FRAMES * count, (0.1, 0.5)), sparse(self.random, (FRAMES * count, 3), 0.3),
                               self.random.uniform(0.01, 3, (FRAMES * count, 1)).astype("f4")], axis=1).reshape(FRAMES, count, 8)
        self.compare([rows], f"option1=yolov8-obb {option2} option3=0:0.3:0.2", lambda r: reference.yolo_obb(r, SIZE, 0.3, 0.2))

    def test_yolov10(self):
        names, option2 = self.numbered_labels(4)
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
class RealModels(DecoderCase):
    """MANIFEST.md: up to 10 px off by the resampler, and a step of the model's input is 4 px wide."""

    PIXELS, SCORE = 14, 0.05
    DETECTION = MODELS / "detection"

    @staticmethod
    def published(photo, model, least, most):
        """Boxes above a score. The decoder suppresses across classes beyond an overlap, the references do not."""
        kept = []
        for name, score, box in results()["detection"][photo][model]:
            box = np.array(box)
            if score > least and not any(overlap(box, other[None])[0] > most for _, _, other in kept):
                kept.append((name, score, box))
        return kept

    def agree(self, published, size, names, decoder, after=""):
        """Every published box is found, and the frame has the boxes that the log names."""
        for photo in ("cats_and_dogs.jpg", "bus.jpg"):
            with self.subTest(photo):
                height, width = size_of(MEDIA / "image" / photo)
                found = self.found(photo, (width, height), size, names, decoder, after)
                wanted = self.published(photo, *published)
                self.assertGreater(len(wanted), 1)
                for label, score, box in wanted:
                    near = [f for f in found if f[0] == label and abs(f[2] - box).max() <= self.PIXELS]
                    self.assertTrue(near, f"{label} at {box} in {found}")
                    self.assertLess(abs(near[0][1] - score), self.SCORE)

    def found(self, photo, output, size, names, decoder, after):
        frame = self.folder / "frame"
        line = (f"filesrc location={MEDIA / 'image' / photo} ! gdkpixbufdec ! videoconvert ! "
                f"videoscale method=bilinear add-borders=false ! video/x-raw,format=RGB,width={size},height={size} ! "
                f"tensor_converter ! tensor_filter framework=tensorflow-lite model={self.DETECTION}/{decoder} "
                f"{self.labels(names)} option4={output[0]}:{output[1]} option5={size}:{size} option7=1 ! "
                f"filesink location={frame} {after}")
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=SECONDS,
                              env=os.environ | {"GST_DEBUG": "weir-bounding_boxes:4", "GST_DEBUG_NO_COLOR": "1"},
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        logged = re.findall(r"\[([\w ]+)\] x:(-?\d+) y:(-?\d+) w:(\d+) h:(\d+) prob:([\d.]+)", done.stdout + done.stderr)
        boxes = [(*map(int, box), names.index(name), float(score), 0) for name, *box, score in logged]
        drawn = np.fromfile(frame, np.uint8).reshape(output[1], output[0], 4)
        Glyphs(RED).compare(drawn, reference.draw(boxes, output, (size, size), names))
        scale = np.tile(np.array(output) / size, 2)
        return [(names[c], score, np.array([x, y, x + w, y + h]) * scale) for x, y, w, h, c, score, _ in boxes]

    def names(self, file):
        return (self.DETECTION / file).read_text().splitlines()

    def test_ssd_with_its_postprocessing(self):
        # This model has no background.
        self.agree(("coco_ssd_postprocess", 0.44, 1), 300, self.names("coco_labels_list.txt")[1:],
                   "coco_ssd_mobilenet_v1_1.0_quant.tflite ! tensor_decoder mode=bounding_boxes "
                   "option1=mobilenet-ssd-postprocess option3=0:1:2:3,40")

    def test_ssd_with_prior_boxes(self):
        scaled = ("d.src_0 ! queue ! tensor_transform mode=arithmetic option=typecast:float32,add:-191,mul:0.0790279 ! m.sink_0 "
                  "d.src_1 ! queue ! tensor_transform mode=arithmetic option=typecast:float32,add:-223,mul:0.0497368 ! m.sink_1")
        self.agree(("ssd_raw_with_priors", 0.44, 0.5), 300, self.names("coco_labels_list.txt"),
                   "ssd_mobilenet_v1_raw_uint8.tflite ! tensor_demux name=d tensor_mux name=m ! tensor_decoder "
                   f"mode=bounding_boxes option1=mobilenet-ssd option3={self.DETECTION / 'box_priors.txt'}:0.4", scaled)

    def test_yolov5(self):
        self.agree(("yolov5n_uint8(stretch 640)", 0.38, 0.5), 640, self.names("coco-80.txt"),
                   "yolov5n_uint8.tflite ! tensor_transform mode=arithmetic option=typecast:float32,mul:0.00419051 ! "
                   "tensor_decoder mode=bounding_boxes option1=yolov5 option3=0:0.3:0.5")


if __name__ == "__main__":
    tap_runner.main()
