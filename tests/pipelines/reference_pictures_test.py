#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares models for pictures with the reference results of ../shared: what they find, with which score, and where.

gdkpixbufdec outputs the same pixels as libjpeg, the references' decoder; other decoders differ by a few steps.
"""

import json
import unittest

import numpy

import tap_runner
from reference_models import (EXACT, MEDIA, MODELS, PIXELS, DetectionCase, ReferenceCase, from_centres, overlap, planes,
                              results, sigmoid, stretched)

BUS, CATS = (1080, 810), (600, 1200)


def labels(name):
    return (MODELS / "detection" / name).read_text().splitlines()


class Detection(DetectionCase):
    def of(self, photo, model, least):
        return [entry for entry in results()["detection"][photo][model] if entry[1] >= least]

    def test_ssd_with_its_own_choice_of_boxes(self):
        coco = numpy.array(labels("coco_labels_list.txt")[1:])
        for photo, size in (("cats_and_dogs.jpg", CATS), ("bus.jpg", BUS)):
            with self.subTest(photo):
                pixels = stretched(self.picture(f"image/{photo}"), 300, 300)[None]
                boxes, classes, scores, count = self.run_model(
                    "detection/coco_ssd_mobilenet_v1_1.0_quant.tflite", [pixels],
                    [((10, 4), "f4"), (10, "f4"), (10, "f4"), ((1,), "f4")])
                n = int(count[0])
                self.assertGreater(n, 3)
                corners = boxes[:n, [1, 0, 3, 2]] * numpy.array([*size[::-1]] * 2)
                self.agree(coco[classes[:n].astype(int)], scores[:n], corners, self.of(photo, "coco_ssd_postprocess", 0.5), 0.55)

    def test_ssd_from_its_priors(self):
        coco = numpy.array(labels("coco_labels_list.txt"))
        prior = numpy.loadtxt(MODELS / "detection/box_priors.txt")  # yc, xc, h, w
        for photo, size in (("cats_and_dogs.jpg", CATS), ("bus.jpg", BUS)):
            with self.subTest(photo):
                pixels = stretched(self.picture(f"image/{photo}"), 300, 300)[None]
                raw, logits = self.run_model("detection/ssd_mobilenet_v1_raw_uint8.tflite", [pixels],
                                             [((1917, 4), "u1"), ((1917, 91), "u1")])
                move = ((raw.astype(float) - 191) * 0.0790279 / [10, 10, 5, 5]).T
                score = sigmoid((logits[:, 1:].astype(float) - 223) * 0.0497368)
                centres = numpy.stack([move[1] * prior[3] + prior[1], move[0] * prior[2] + prior[0]], axis=1)
                sizes = numpy.stack([numpy.exp(move[3]) * prior[3], numpy.exp(move[2]) * prior[2]], axis=1)
                boxes = from_centres(centres, sizes) * numpy.array([*size[::-1]] * 2)
                self.agree(coco[score.argmax(axis=1) + 1], score.max(axis=1), boxes, self.of(photo, "ssd_raw_with_priors", 0.5), 0.6)

    def test_yolov5(self):
        coco = numpy.array(labels("coco-80.txt"))
        for photo, size in (("cats_and_dogs.jpg", CATS), ("bus.jpg", BUS)):
            with self.subTest(photo):
                pixels = stretched(self.picture(f"image/{photo}"), 640, 640)[None]
                rows = self.run_model("detection/yolov5n_uint8.tflite", [pixels], [((25200, 85), "u1")]) * 0.00419051
                score = rows[:, 4:5] * rows[:, 5:]
                boxes = from_centres(rows[:, :2], rows[:, 2:4]) * numpy.array([*size[::-1]] * 2)
                self.agree(coco[score.argmax(axis=1)], score.max(axis=1), boxes, self.of(photo, "yolov5n_uint8(stretch 640)", 0.4), 0.6)

    def yolox(self, photo, size, model):
        factor = 416 / max(size)
        height, width = (int(side * factor) for side in size)
        pixels = numpy.full((416, 416, 3), 114, "u1")
        pixels[:height, :width] = stretched(self.picture(f"image/{photo}", "BGR"), width, height)
        return self.run_model(f"detection/{model}", [planes(pixels)], [((3549, 85), "f4")]), factor

    def test_yolox(self):
        coco = numpy.array(labels("coco-80.txt"))
        steps = [8] * 52 * 52 + [16] * 26 * 26 + [32] * 13 * 13
        stride = numpy.array(steps)[:, None]
        cells = numpy.concatenate([numpy.stack(numpy.meshgrid(range(n), range(n)), axis=2).reshape(-1, 2) for n in (52, 26, 13)])
        for photo, size in (("cats_and_dogs.jpg", CATS), ("bus.jpg", BUS)):
            with self.subTest(photo):
                rows, factor = self.yolox(photo, size, "yolox_nano.onnx")
                score = rows[:, 4:5] * rows[:, 5:]
                boxes = from_centres((rows[:, :2] + cells) * stride, numpy.exp(rows[:, 2:4]) * stride) / factor
                self.agree(coco[score.argmax(axis=1)], score.max(axis=1), boxes,
                           self.of(photo, "yolox_nano.onnx(letterbox 416)", 0.5), 0.7, EXACT)

    def test_yolox_of_half_precision_is_that_of_single_precision(self):
        single, _ = self.yolox("bus.jpg", BUS, "yolox_nano.onnx")
        half, _ = self.yolox("bus.jpg", BUS, "yolox_nano_float16.tflite")
        sure = single[:, 4] > 0.3
        self.assertGreater(sure.sum(), 3)
        self.assertLess(abs(single - half)[sure].max(), 0.05, "weights of 11 bits")

    def test_fastestdet(self):
        coco = numpy.array(labels("coco-80.txt"))
        pixels = stretched(self.picture("image/bus.jpg", "BGR"), 352, 352)
        out = self.run_model("detection/FastestDet.onnx", [planes(pixels) / numpy.float32(255)], [((85, 22, 22), "f4")])
        out = out.reshape(85, -1).T
        cells = numpy.stack(numpy.meshgrid(range(22), range(22)), axis=2).reshape(-1, 2)
        score = out[:, :1] ** 0.6 * out[:, 5:].max(axis=1)[:, None] ** 0.4
        boxes = from_centres((cells + numpy.tanh(out[:, 1:3])) / 22, sigmoid(out[:, 3:5])) * numpy.array([*BUS[::-1]] * 2)
        self.agree(coco[out[:, 5:].argmax(axis=1)], score[:, 0], boxes, results("reference_results_extra")["FastestDet bus"], 0.75,
                   EXACT)

    def test_palm(self):
        """MANIFEST.md: raw score 38.4 at anchor 2351; the previous anchor has the same score and these regressors."""
        pixels = (stretched(self.picture("image/hand_vsign.jpg"), 256, 256)[None] - numpy.float32(127.5)) / numpy.float32(127.5)
        scores, moves = self.run_model("detection/palm_detection_256_int8.tflite", [pixels], [((2944,), "f4"), ((2944, 18), "f4")])
        self.assertIn(scores.argmax(), (2350, 2351))
        self.assertAlmostEqual(scores.max(), 38.4, delta=0.1)
        reference = results()["detection"]["hand_vsign.jpg"]
        self.assertLess(abs(moves[reference["anchor index"]] - reference["raw regressor"]).max(), 5)


class Faces(ReferenceCase):
    SIZE = (861, 1049)  # three_people.jpg

    def agree(self, scores, boxes, reference, score, pixels):
        for _, wanted, box in reference:
            near = (abs(scores - wanted) < score) & (abs(boxes - numpy.array(box)).max(axis=1) < pixels)
            self.assertTrue(near.any(), f"{wanted} {box}")
        known = numpy.array([box for _, _, box in reference])
        for box in boxes[scores > 0.75]:
            self.assertGreater(overlap(box, known).max(), 0.5)

    def small(self):
        pixels = stretched(self.picture("face/three_people.jpg"), 320, 240)
        return (pixels - numpy.float32(127)) / numpy.float32(128)

    def test_ultraface(self):
        outputs = [((4420, 2), "f4"), ((4420, 4), "f4")]
        scores, boxes = self.run_model("face/ultraface_RFB-320.onnx", [planes(self.small())], outputs)
        reference = results("reference_results_extra")["ultraface onnx three_people"]
        self.agree(scores[:, 1], boxes * numpy.array([*self.SIZE[::-1]] * 2), reference, 0.01, EXACT)
        _, raw = self.run_model("face/ultraface_RFB-320_raw.tflite", [self.small()[None]], outputs[::-1])
        self.assertLess(abs(raw - scores).max(), 1e-3)

    def test_yunet(self):
        pixels = numpy.zeros((864, 1056, 3), "u1")
        pixels[:861, :1049] = self.picture("face/three_people.jpg", "BGR")
        cells = [(864 // step, 1056 // step, step) for step in (8, 16, 32)]
        outputs = [((rows * columns, width), "f4") for width in (1, 1, 4, 10) for rows, columns, _ in cells]
        out = self.run_model("face/yunet_n_dynamic.onnx", [planes(pixels)], outputs)
        scores, boxes = [], []
        for n, (rows, columns, step) in enumerate(cells):
            grid = numpy.stack(numpy.meshgrid(range(columns), range(rows)), axis=2).reshape(-1, 2)
            scores.append(numpy.sqrt(out[n][:, 0] * out[n + 3][:, 0]))
            boxes.append(from_centres((grid + out[n + 6][:, :2]) * step, numpy.exp(out[n + 6][:, 2:]) * step))
        self.agree(numpy.concatenate(scores), numpy.concatenate(boxes), results("reference_results_extra")["yunet three_people"],
                   0.05, PIXELS)

    def test_blazeface_finds_the_faces_that_mtcnn_finds(self):
        """MANIFEST.md: .96 on an unspecified crop; here a crop twice the face's size, by another network's box."""
        grids = ((16, 2), (8, 6))  # cells per side, anchors per cell
        cells = numpy.concatenate([numpy.repeat((numpy.stack(numpy.meshgrid(range(n), range(n)), axis=2).reshape(-1, 2) + 0.5) / n,
                                                anchors, axis=0) for n, anchors in grids])
        for photo in ("faces", "ivan", "obama-1080p", "three_people"):
            face = results()["mtcnn"][f"{photo}.jpg"]["consensus"][0]
            box = numpy.array(face["box"])
            side = int(2 * (box[2:] - box[:2]).max())
            x, y = ((box[:2] + box[2:] - side) / 2).clip(0).astype(int)
            crop = self.picture(f"face/{photo}.jpg")[y:y + side, x:x + side]
            pixels = (stretched(crop, 128, 128)[None] - numpy.float32(127.5)) / numpy.float32(127.5)
            moves, scores = self.run_model("face/blazeface_short_range.tflite", [pixels], [((896, 8, 2), "f4"), ((896,), "f4")])
            best = scores.argmax()
            self.assertGreater(sigmoid(scores[best]), 0.9, photo)
            eyes = (cells[best] + moves[best, 2:4] / 128) * crop.shape[1::-1] + (x, y)
            off = numpy.hypot(*(eyes - numpy.array(face["landmarks"][:2])).T)
            self.assertLess(off.max(), 0.2 * (box[2] - box[0]), photo)


class PosesAndMasks(ReferenceCase):
    JOINTS = ("nose", *(f"{side}_{part}" for part in ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
                        for side in ("left", "right")))

    def movenet(self, picture):
        found = self.run_model("pose/movenet_lightning_ptq.tflite", [stretched(picture, 192, 192)[None]], [((17, 3), "f4")])
        return found[:, [1, 0]] * numpy.array(picture.shape[1::-1]), found[:, 2]

    def posenet(self, picture):
        heat, offsets, _ = self.run_model("pose/posenet_mobilenet_v1_075_353_481_quant.tflite", [stretched(picture, 481, 353)[None]],
                                          [((23 * 31, 17), "u1"), ((23 * 31, 34), "u1"), ((23 * 31, 64), "u1")])
        at = heat.argmax(axis=0)
        moves = (offsets.astype(float) - 128) * 0.0784314
        joints = numpy.arange(17)
        x = at % 31 * 16 + moves[at, joints + 17]
        y = at // 31 * 16 + moves[at, joints]
        scores = sigmoid((heat.astype(float).max(axis=0) - 128) * 0.0784314)
        return numpy.stack([x / 481, y / 353], axis=1) * numpy.array(picture.shape[1::-1]), scores

    def test_joints_of_a_photo(self):
        picture = self.picture("image/posenet_couple.jpg")
        cell = numpy.array(picture.shape[1::-1]) / 48  # movenet's cell; its first layer amplifies one step of a colour
        for name, find, pixels, score in (("movenet(stretch 192)", self.movenet, 1.5 * cell, 0.25),
                                          ("posenet_075_353x481(stretch, per-keypoint argmax)", self.posenet, 3, 0.02)):
            with self.subTest(name):
                places, scores = find(picture)
                for joint, place, sure in zip(self.JOINTS, places, scores):
                    x, y, wanted = results()["pose"]["posenet_couple.jpg"][name][joint]
                    if wanted < 0.5:
                        continue
                    self.assertTrue((abs(place - (x, y)) < pixels).all(), f"{joint}: {place} instead of {x}, {y}")
                    self.assertAlmostEqual(sure, wanted, delta=score, msg=joint)

    def test_joints_of_a_video_are_those_that_were_published(self):
        """The reference comes from another network, BlazePose; MANIFEST.md: 9 joints at most 18.2 and 14.8 px apart."""
        published = json.loads((MEDIA / "video/pose_1.json").read_text())[0]
        picture = self.first_frame("video/pose_1.mp4", (576, 576))
        for find in (self.movenet, self.posenet):
            places, _ = find(picture)
            for joint, place in zip(self.JOINTS, places):
                if joint.split("_")[-1] not in ("nose", "shoulder", "elbow", "hip", "knee"):
                    continue
                wanted = published[joint]
                self.assertLess(numpy.hypot(*(place - (wanted["x"], wanted["y"]))), 20, f"{find.__name__} {joint}")

    def test_masks_are_the_published_ones(self):
        golden = self.picture("image/segmentation_golden.png", "GRAY8")[:, :, 0] // 10
        picture = self.picture("image/segmentation_input.jpg")
        pixels = (stretched(picture, 257, 257)[None] - numpy.float32(127.5)) / numpy.float32(127.5)
        classes = self.run_model("segmentation/deeplabv3_257_mv_gpu.tflite", [pixels], [((257, 257, 21), "f4")]).argmax(axis=2)
        self.assertEqual(set(numpy.unique(golden)), {0, 13, 15}, "background, horse, person")
        self.assertGreater((classes == golden).mean(), 0.999)


if __name__ == "__main__":
    tap_runner.main()
