#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds the heads of faces, hands, bodies and text to real models and reference results.

Models that npm packages contain (PP-OCR, MediaPipe) are looked for in WEIR_OCR_MODELS and
WEIR_MEDIAPIPE_MODELS: folders with the packages' files.
"""

import json
import os
import pathlib
import subprocess
import unittest

import numpy

import tap_runner
from built_modules import has_engine
from reference_models import MEDIA, MODELS, ReferenceCase, overlap, planes, results, stretched

JOINTS = ("nose", *(f"{side}_{part}" for part in ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
                    for side in ("left", "right")))
EXTRA = "reference_results_extra"


def unit(pixels):
    """Pixels as MediaPipe's networks take them: -1 to 1."""
    return ((pixels - numpy.float32(127.5)) / numpy.float32(127.5)).astype("f4")


class HeadCase(ReferenceCase):
    def answer(self, model, mode, array, **options):
        """What the mode finds in the outputs of a model: rows in pixels of the model's input."""
        model = model if isinstance(model, pathlib.Path) else MODELS / model
        engine = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite"}[model.suffix]
        if not has_engine(engine):
            self.skipTest(f"the engine {engine} is not built")
        path = self.folder / "input.raw"
        numpy.ascontiguousarray(array).tofile(path)
        dimensions = ":".join(str(extent) for extent in reversed(array.shape))
        done = subprocess.run([os.environ["WEIR_ANSWER"], model, mode, path, array.dtype.name, dimensions,
                               *(f"{key.replace('_', '-')}={value}" for key, value in options.items())],
                              capture_output=True, text=True, timeout=200)
        if done.returncode:
            raise RuntimeError(done.stderr)
        return json.loads(done.stdout)

    def refusal(self, *arguments, **options):
        with self.assertRaises(RuntimeError) as caught:
            self.answer(*arguments, **options)
        return str(caught.exception)

    def crop(self, photo, box, by, size):
        """A square around a box, `by` times its greater side; returns the pixels, its corner and its side."""
        x1, y1, x2, y2 = box
        side = by * max(x2 - x1, y2 - y1)
        x, y = (x1 + x2 - side) / 2, (y1 + y2 - side) / 2
        x, y, side = max(0, int(x)), max(0, int(y)), int(side)
        part = self.picture(photo)[y:y + side, x:x + side]
        return stretched(part, size, size), numpy.array([x, y]), numpy.array(part.shape[1::-1]) / size


class Faces(HeadCase):
    SIZE = numpy.array([1049, 861])  # three_people.jpg

    def small(self):
        pixels = stretched(self.picture("face/three_people.jpg"), 320, 240)
        return ((pixels - numpy.float32(127)) / numpy.float32(128)).astype("f4")

    def agree(self, rows, scale, reference, score, pixels):
        """Each face of the reference is found, and no other."""
        self.assertEqual(len(rows), len(reference), rows)
        for row, (_, wanted, box) in zip(rows, reference):
            self.assertAlmostEqual(row["score"], wanted, delta=score)
            self.assertLess(abs(numpy.array(row["box"]) * [*scale, *scale] - box).max(), pixels)

    def test_ultraface(self):
        reference = results(EXTRA)["ultraface onnx three_people"]
        scale = self.SIZE / [320, 240]
        for model, array, options in (("face/ultraface_RFB-320.onnx", planes(self.small()), {}),
                                      ("face/ultraface_RFB-320_raw.tflite", self.small()[None], {"head": "ultraface-raw"})):
            with self.subTest(model):
                rows = self.answer(model, "detection", array, iou=0.3, **options)
                self.agree(sorted(rows, key=lambda row: row["box"][0]), scale, sorted(reference, key=lambda entry: entry[2][0]), 0.01, 2)

    def test_boxes_of_ultraface_may_be_of_either_kind(self):
        said = self.refusal("face/ultraface_RFB-320_raw.tflite", "detection", self.small()[None])
        self.assertIn("the outputs fit several heads: ultraface, ultraface-raw", said)
        self.assertIn("custom=head:ultraface or tensor_decoder custom=head:ultraface-raw", said)

    def test_yunet(self):
        pixels = numpy.zeros((864, 1056, 3), "u1")
        pixels[:861, :1049] = self.picture("face/three_people.jpg", "BGR")
        rows = self.answer("face/yunet_n_dynamic.onnx", "detection", planes(pixels))
        self.assertEqual([row["score"] for row in rows], sorted((row["score"] for row in rows), reverse=True))
        self.agree(sorted(rows, key=lambda row: -row["box"][0]), [1, 1],
                   sorted(results(EXTRA)["yunet three_people"], key=lambda entry: -entry[2][0]), 0.05, 10)
        for face in results()["mtcnn"]["three_people.jpg"]["consensus"]:
            row = max(rows, key=lambda row: overlap(numpy.array(row["box"]), numpy.array([face["box"]]))[0])
            points = numpy.array(row["points"])[:, :2]
            width = row["box"][2] - row["box"][0]
            self.assertLess(numpy.hypot(*(points - face["landmarks"]).T).max(), 0.15 * width, "eyes, nose and mouth of MTCNN")

    def test_blazeface_finds_the_faces_that_mtcnn_finds(self):
        for photo in ("faces", "ivan", "obama-1080p", "three_people"):
            with self.subTest(photo):
                face = results()["mtcnn"][f"{photo}.jpg"]["consensus"][0]
                pixels, corner, scale = self.crop(f"face/{photo}.jpg", face["box"], 2, 128)
                rows = self.answer("face/blazeface_short_range.tflite", "detection", unit(pixels)[None])
                best = rows[0]
                self.assertGreater(best["score"], 0.9)
                eyes = numpy.array(best["points"])[:2, :2] * scale + corner
                width = face["box"][2] - face["box"][0]
                self.assertLess(numpy.hypot(*(eyes - face["landmarks"][:2]).T).max(), 0.2 * width)
                box = numpy.array(best["box"]) * [*scale, *scale] + [*corner, *corner]
                self.assertGreater(overlap(box, numpy.array([face["box"]]))[0], 0.4)

    def test_no_face_in_a_grey_picture(self):
        self.assertEqual(self.answer("face/blazeface_short_range.tflite", "detection", numpy.zeros((1, 128, 128, 3), "f4")), [])
        self.assertEqual(self.answer("face/ultraface_RFB-320.onnx", "detection", numpy.zeros((1, 3, 240, 320), "f4")), [])

    def test_face_landmarks_are_where_mtcnn_finds_them(self):
        """Points of MediaPipe's mesh: 1 is the tip of the nose, 61 and 291 are the corners of the mouth."""
        for photo in ("ivan", "obama-1080p", "three_people"):
            with self.subTest(photo):
                face = results()["mtcnn"][f"{photo}.jpg"]["consensus"][0]
                pixels, corner, scale = self.crop(f"face/{photo}.jpg", face["box"], 1.5, 192)
                rows = self.answer("face/face_landmark.tflite", "pose", unit(pixels)[None])
                self.assertEqual(len(rows), 1)
                self.assertGreater(rows[0]["score"], 0.9)
                points = numpy.array(rows[0]["points"])
                self.assertEqual(points.shape, (468, 3))
                found = points[[1, 61, 291], :2] * scale + corner
                width = face["box"][2] - face["box"][0]
                self.assertLess(numpy.hypot(*(found - face["landmarks"][2:]).T).max(), 0.2 * width)

    def test_a_grey_picture_has_no_landmarks(self):
        self.assertEqual(self.answer("face/face_landmark.tflite", "pose", numpy.zeros((1, 192, 192, 3), "f4")), [])


class Hands(HeadCase):
    def test_palm(self):
        """MANIFEST.md: the palm's centre is at (434, 542), its side is 269 of 900 pixels."""
        pixels = unit(stretched(self.picture("image/hand_vsign.jpg"), 256, 256))[None]
        rows = self.answer("detection/palm_detection_256_int8.tflite", "detection", pixels)
        self.assertGreaterEqual(len(rows), 1)
        self.assertGreater(rows[0]["score"], 0.99)
        x1, y1, x2, y2 = numpy.array(rows[0]["box"]) * 900 / 256
        self.assertLess(max(abs((x1 + x2) / 2 - 434), abs((y1 + y2) / 2 - 542)), 10)
        self.assertAlmostEqual(x2 - x1, 269, delta=15)
        self.assertLess(abs(rows[0]["rotation"]), 0.7, "the fingers point upwards")
        self.assertEqual(len(rows[0]["points"]), 7)


class Bodies(HeadCase):
    def joints(self, row, picture, size):
        points = numpy.array(row["points"])
        return points[:, :2] * (numpy.array(picture.shape[1::-1]) / size), points[:, 2]

    def reference(self, model):
        found = results()["pose"]["posenet_couple.jpg"][model]
        return numpy.array([found[joint] for joint in JOINTS])

    def agrees_with_the_published_pose(self, model, size):
        """The reference comes from another network, BlazePose; MANIFEST.md: 9 joints at most 18.2 and 14.8 px apart."""
        picture = self.first_frame("video/pose_1.mp4", (576, 576))
        rows = self.answer(model, "pose", stretched(picture, *size)[None])
        self.assertEqual(len(rows), 1)
        published = json.loads((MEDIA / "video/pose_1.json").read_text())[0]
        for joint, place in zip(JOINTS, self.joints(rows[0], picture, size)[0]):
            if joint.split("_")[-1] in ("nose", "shoulder", "elbow", "hip", "knee"):
                wanted = published[joint]
                self.assertLess(numpy.hypot(*(place - (wanted["x"], wanted["y"]))), 20, joint)

    def test_movenet(self):
        picture = self.picture("image/posenet_couple.jpg")
        rows = self.answer("pose/movenet_lightning_ptq.tflite", "pose", stretched(picture, 192, 192)[None])
        at, scores = self.joints(rows[0], picture, (192, 192))
        reference = self.reference("movenet(stretch 192)")
        cell = numpy.array(picture.shape[1::-1]) / 48  # its first layer amplifies one step of a colour
        sure = reference[:, 2] >= 0.5
        self.assertTrue((abs(at - reference[:, :2])[sure] < 1.5 * cell).all())
        self.assertLess(abs(scores - reference[:, 2])[sure].max(), 0.25)
        self.assertAlmostEqual(rows[0]["score"], scores.mean(), delta=1e-4)

    def test_movenet_agrees_with_the_published_pose(self):
        self.agrees_with_the_published_pose("pose/movenet_lightning_ptq.tflite", (192, 192))

    def test_posenet_finds_both_persons(self):
        """The reference has each joint's best cell, of one person or of the other. In the small faces it joins both."""
        picture = self.picture("image/posenet_couple.jpg")
        rows = self.answer("pose/posenet_mobilenet_v1_075_353_481_quant.tflite", "pose", stretched(picture, 481, 353)[None])
        self.assertEqual(len(rows), 2)
        persons = [self.joints(row, picture, (481, 353)) for row in rows]
        reference = self.reference("posenet_075_353x481(stretch, per-keypoint argmax)")
        cell = picture.shape[1] / 31
        for joint, (x, y, score) in enumerate(reference):
            if joint >= JOINTS.index("left_shoulder") and score > 0.9:
                self.assertLess(min(numpy.hypot(*(at[joint] - (x, y))) for at, _ in persons), cell / 4, JOINTS[joint])
        noses = sorted(at[0, 0] for at, _ in persons)
        self.assertLess(noses[0], 900)
        self.assertGreater(noses[1], 900)

    def test_posenet_agrees_with_the_published_pose(self):
        self.agrees_with_the_published_pose("pose/posenet_mobilenet_v1_075_353_481_quant.tflite", (481, 353))

    def test_nobody_in_a_grey_picture(self):
        self.assertEqual(self.answer("pose/posenet_mobilenet_v1_075_353_481_quant.tflite", "pose",
                                     numpy.full((1, 353, 481, 3), 128, "u1")), [])


if __name__ == "__main__":
    tap_runner.main()
