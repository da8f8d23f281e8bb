#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares the face detection example with the reference's faces on the photos and the video of ../shared.

Criteria (../shared/MANIFEST.md, MTCNN facts): each consensus face is found with an IoU of at least 0.7, its landmarks
differ by at most 0.2 of its width and in the median by 0.05, and each face scored 0.95 is in one of the reference's lists.
"""

import json
import math
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
NETWORKS = SHARED / "models/face/mtcnn"
LEAST_OVERLAP, MOST_OFF, MEDIAN_OFF, SURE, SAME = 0.7, 0.2, 0.05, 0.95, 0.5
AT_THE_EDGE = 0.12  # of the face's width: at least a quarter of the face is outside the picture


def overlap(a, b):
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (a, b)]
    return width * height / (sum(areas) - width * height)


CONTROL, ROS = BUILD / "benchmarks/mtcnn/mtcnn-control", BUILD / "benchmarks/mtcnn/ros/mtcnn-ros-camera"


def run(*arguments, other=None):
    """`other`: the option of benchmarks/mtcnn/run for another program."""
    command = [SOURCE / "benchmarks/mtcnn/run", other] if other else [SOURCE / "examples/mtcnn/run"]
    return subprocess.run([*command, *map(str, arguments)],
                          capture_output=True, text=True, timeout=300, env={**os.environ, "WEIR_BUILD": str(BUILD)})


class Faces(unittest.TestCase):
    def setUp(self):
        if not NETWORKS.is_dir():
            self.skipTest(f"{NETWORKS} is not there")
        self.reference = json.loads((SHARED / "media/reference_results.json").read_text())

    def found(self, *arguments, **options):
        done = run("--models", NETWORKS, "--json", *arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+|CRITICAL|WARNING")
        return [json.loads(line) for line in done.stdout.splitlines()]

    def hold(self, faces, reference, name):
        """The worst landmark of each consensus face, in face widths."""
        off = []
        for face in reference["consensus"]:
            best = max(faces, key=lambda one: overlap(one["box"], face["box"]), default=None)
            self.assertIsNotNone(best, f"{name}: no face, not {face}")
            self.assertGreaterEqual(overlap(best["box"], face["box"]), LEAST_OVERLAP, f"{name}: {face} and {best}")
            width = face["box"][2] - face["box"][0]
            off.append(max(math.dist(*points) for points in zip(best["landmarks"], face["landmarks"])) / width)
            self.assertLessEqual(off[-1], MOST_OFF, f"{name}: {face} and {best}")
        known = [face["box"] for resampler in ("area", "linear") for face in reference[resampler]["faces"]]
        for face in faces:
            if face["score"] >= SURE:
                self.assertTrue(any(overlap(face["box"], box) >= SAME for box in known), f"{name}: {face} is unknown")
        return off

    def test_photos(self):
        self.photos()

    def test_onnxruntime(self):
        if not has_engine("onnxruntime"):
            self.skipTest("the engine onnxruntime is not built")
        self.photos("--framework", "onnxruntime")
        self.video("--framework", "onnxruntime")

    def test_photos_of_the_control(self):
        if not CONTROL.exists():
            self.skipTest("the control is not built")
        self.photos(other="--control")

    def test_kernels_of_our_own(self):
        """With 8 bits in all networks, and only in P-Net; float32 is the default."""
        for precision in ("int8", "mixed"):
            options = ("--framework", "mtcnn-kernels", "--custom", "Precision:" + precision)
            self.photos(*options)
            self.video(*options)
        photo = ("--framework", "mtcnn-kernels", "--min-face", 20, SHARED / "media/face/faces.jpg")
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "onnx_nhwc").symlink_to(NETWORKS / "onnx_nhwc")
            fetched = run("--models", folder, "--json", *photo)
        self.assertEqual(fetched.returncode, 0, fetched.stderr[-2000:])
        self.assertEqual(len(json.loads(fetched.stdout)), len(self.found(*photo)[0]), "the files that fetch brings")
        done = run("--models", NETWORKS, "--framework", "mtcnn-kernels", "--custom", "Precision:2", SHARED / "media/face/faces.jpg")
        self.assertEqual(done.returncode, 1)
        self.assertIn("needed: one of: float32, mixed, int8", done.stderr)

    def photos(self, *options, other=None):
        off = []
        for name, reference in self.reference["mtcnn"].items():
            pictures = self.found(*options, "--min-face", reference["minsize"], SHARED / "media/face" / name, other=other)
            self.assertEqual(len(pictures), 1, name)
            off += self.hold(pictures[0], reference, name)
        self.assertGreater(len(off), 10)
        self.assertLessEqual(statistics.median(off), MEDIAN_OFF)

    def test_faces_at_the_edge_of_the_picture(self):
        """A face with a part cut off is found, with the same landmarks as in the whole photo."""
        for other in (None, "--control"):
            if other and not CONTROL.exists():
                self.skipTest("the control is not built")
            for name, side, share in (("ivan.jpg", "bottom", 0.35), ("ivan.jpg", "right", 0.25), ("faces.jpg", "right", 0.25),
                                      ("obama-1080p.jpg", "left", 0.2), ("obama-1080p.jpg", "top", 0.25)):
                with self.subTest(f"{name} {side} {share}", other=other):
                    self.at_the_edge(SHARED / "media/face" / name, side, share, other)

    def at_the_edge(self, photo, side, share, other):
        face = self.found(photo, other=other)[0][0]
        left, top, right, bottom = face["box"]
        # The part of the photo after the cut, or before it.
        cut = {"left": left + share * (right - left), "right": right - share * (right - left),
               "top": top + share * (bottom - top), "bottom": bottom - share * (bottom - top)}[side]
        with tempfile.TemporaryDirectory() as folder:
            part = pathlib.Path(folder) / "part.png"
            width, height = self.size_of(photo)
            away = {"left": cut, "top": cut, "right": width - cut, "bottom": height - cut}[side]
            subprocess.run(f"gst-launch-1.0 -q filesrc location={photo} ! decodebin ! videoconvert ! video/x-raw,format=RGB ! "
                           f"videocrop {side}={round(away)} ! pngenc ! filesink location={part}".split(), check=True, timeout=60)
            faces = self.found(part, other=other)[0]
        x, y = round(away) if side == "left" else 0, round(away) if side == "top" else 0
        for one in faces:
            one["box"] = [n + (x, y)[i % 2] for i, n in enumerate(one["box"])]
        best = max(faces, key=lambda one: overlap(one["box"], face["box"]), default={"box": [0] * 4})
        self.assertGreaterEqual(overlap(best["box"], face["box"]), LEAST_OVERLAP, faces)
        off = max(math.dist((p[0] + x, p[1] + y), q) for p, q in zip(best["landmarks"], face["landmarks"])) / (right - left)
        self.assertLessEqual(off, AT_THE_EDGE, f"{best} and {face}")

    def size_of(self, photo):
        done = subprocess.run(f"gst-launch-1.0 -v filesrc location={photo} ! decodebin ! fakesink".split(), capture_output=True,
                              text=True, check=True, timeout=60)
        return [int(re.search(rf"{side}=\(int\)(\d+)", done.stdout)[1]) for side in ("width", "height")]

    def test_nodes_over_topics(self):
        """P-, R- and O-Net as ROS 1 nodes: the control's numbers, and its errors."""
        if not (ROS.exists() and shutil.which("roslaunch")):
            self.skipTest("ROS 1 is not installed (libroscpp-dev, python3-roslaunch)")
        photo = SHARED / "media/face/faces.jpg"
        self.assertEqual(self.found(photo, other="--ros"), self.found(photo, other="--control"))
        with tempfile.TemporaryDirectory() as folder:
            done = run("--json", "--models", folder, photo, other="--ros")
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn("onnx/pnet.onnx", done.stderr)
        done = run("--json", "--models", NETWORKS, SOURCE / "README.md", other="--ros")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("control: ", done.stderr)

    def test_formats(self):
        """The same weights in other formats and picture orders, each in its engine, find the same faces."""
        photo = ("--min-face", 20, SHARED / "media/face/faces.jpg")
        if not has_engine("onnxruntime"):
            self.skipTest("the engine onnxruntime is not built")
        wanted = self.found("--framework", "onnxruntime", *photo)[0]
        self.assertEqual(len(wanted), 6)
        runs = {engine: ("--framework", engine) for engine in ("pytorch", "caffe", "tensorflow-lite") if has_engine(engine)}
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "onnx_nhwc").symlink_to(NETWORKS / "onnx_nhwc")
            runs["colours beside each other"] = ("--framework", "onnxruntime", "--models", folder)
            for name, options in runs.items():
                done = run(*(options if "--models" in options else ("--models", NETWORKS, *options)), "--json", *photo)
                self.assertEqual(done.returncode, 0, f"{name}: {done.stderr[-2000:]}")
                self.same(json.loads(done.stdout), wanted, name)

    def same(self, found, wanted, name):
        self.assertEqual(len(found), len(wanted), name)
        for one, other in zip(found, wanted):
            numbers = [(*face["box"], face["score"], *(n for point in face["landmarks"] for n in point)) for face in (one, other)]
            self.assertLess(max(abs(a - b) for a, b in zip(*numbers)), 0.2, f"{name}: {one} and {other}")

    def test_kernels_of_our_own_see_what_onnxruntime_sees(self):
        """The default, which takes pictures as bytes, and ONNX Runtime on the same bytes find the same faces."""
        if not has_engine("onnxruntime"):
            self.skipTest("the engine onnxruntime is not built")
        for name, reference in self.reference["mtcnn"].items():
            photo = ("--min-face", reference["minsize"], SHARED / "media/face" / name)
            self.same(self.found(*photo)[0], self.found("--framework", "onnxruntime", "--rounded", *photo)[0], name)

    def test_video(self):
        self.video()

    def video(self, *options):
        video = self.reference["mtcnn_video"]["street_1080p25.mp4"]
        pictures = self.found(*options, SHARED / "media/video/street_1080p25.mp4")
        self.assertEqual(len(pictures), video["frames"], "a list for each picture")
        for number, reference in video["refs"].items():
            self.hold(pictures[int(number)], reference, f"frame {number}")

    def test_annotated_clip(self):
        """The clip of the display branch has every picture at the video's size."""
        with tempfile.TemporaryDirectory() as folder:
            clip = pathlib.Path(folder) / "faces.mkv"
            done = run("--models", NETWORKS, "--output", clip, SHARED / "media/video/faces_800x720.mp4")
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            self.assertGreater(clip.stat().st_size, 100_000)

    def test_files_that_are_none(self):
        done = run("--models", NETWORKS, "--json", SOURCE / "README.md")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout, "")
        done = run("--models", NETWORKS, "--json", SOURCE / "nowhere.jpg")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"WEIR-\d+: ")

    def test_networks_that_are_not_there(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run("--models", folder, SHARED / "media/face/faces.jpg")
            self.assertEqual(done.returncode, 1)
            self.assertIn("WEIR-4001: MTCNN's networks are not there", done.stderr)
            self.assertIn("fix: examples/mtcnn/fetch", done.stderr)
        done = run("--models", NETWORKS, "--framework", "abacus", SHARED / "media/face/faces.jpg")
        self.assertIn("WEIR-1004: MTCNN's networks are in no format for this framework", done.stderr)
        self.assertIn("onnxruntime, mtcnn-kernels, pytorch, caffe or tensorflow-lite", done.stderr)

    def test_pictures_smaller_than_a_face(self):
        self.assertEqual(self.found("--min-face", 1000, SHARED / "media/face/faces.jpg"), [[]])
        video = SHARED / "media/video/pose_1.mp4"
        empty = self.found("--min-face", 4096, video)
        self.assertEqual(empty, [[]] * len(empty))
        self.assertGreater(len(empty), 1, "a list for each picture")

    def test_smallest_faces_that_are_none(self):
        for size, words in (("0", "Value 0 not in range"), ("11", "Value 11 not in range"), ("5000", "Value 5000 not in range"),
                            ("-1", "--min-face"), ("many", "--min-face")):
            done = run("--models", NETWORKS, "--json", "--min-face", size, SHARED / "media/face/faces.jpg")
            self.assertGreater(done.returncode, 0, size)
            self.assertEqual(done.stdout, "", size)
            self.assertIn(words, done.stderr)

    def test_a_cascade_that_stalls(self):
        """A clip with one picture per second, while a result is expected every tenth of a second."""
        sys.path.insert(0, str(SOURCE / "benchmarks/mtcnn/measure"))
        import clips

        with tempfile.TemporaryDirectory() as folder:
            clip = clips.Clip(SHARED / "media/video/pose_1.mp4").again(pathlib.Path(folder) / "slow.mkv", 1, 4)
            done = run("--models", NETWORKS, "--live", "--min-face", 100, "--patience", 0.1, clip)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("no results come", done.stderr)
        self.assertIn("offered: none for 0.1 seconds", done.stderr)
        self.assertIn("needed: one for each picture", done.stderr)

    def test_patience_that_is_none(self):
        done = run("--models", NETWORKS, "--patience", 0, SHARED / "media/face/faces.jpg")
        self.assertGreater(done.returncode, 0)
        self.assertIn("--patience", done.stderr)

    def test_what_is_not_there_is_named(self):
        for other, program, fix in ((None, "mtcnn", "make build"), ("--control", "mtcnn-control", "libopencv-imgproc-dev"),
                                    ("--ros", "mtcnn-ros-camera", "libroscpp-dev")):
            done = run("--build", "/nowhere", "clip.mp4", other=other)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, f"{program} is not built\n  fix: .*{fix}")
        with tempfile.TemporaryDirectory() as folder:
            nodes = pathlib.Path(folder) / "benchmarks/mtcnn/ros"
            nodes.mkdir(parents=True)
            for name in ("camera", "p", "r", "o"):
                (nodes / f"mtcnn-ros-{name}").touch()
            done = run("--build", folder, "clip.mp4", other="--ros")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"package\.xml is not built\n  fix: .*libroscpp-dev")

    def test_networks_are_fetched_or_their_source_is_named(self):
        """Without real models and without network access."""
        with tempfile.TemporaryDirectory() as home:
            nowhere = {name: value for name, value in os.environ.items() if name not in ("MTCNN_MODELS", "WEIR_DATA")}
            nowhere |= {"XDG_CACHE_HOME": home, "https_proxy": "http://127.0.0.1:9", "no_proxy": ""}
            example = pathlib.Path(home) / "checkout/examples/mtcnn"
            example.mkdir(parents=True)
            for name in ("run", "fetch"):
                shutil.copy(SOURCE / "examples/mtcnn" / name, example)
            done = subprocess.run([example / "run", "--build", BUILD, "clip.mp4"], capture_output=True, text=True, env=nowhere)
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn(f"they are fetched\n  looked in: {home}/weir/mtcnn\n", done.stderr)
            self.assertRegex(done.stderr, r"https://\S+/pnet\.onnx cannot be reached: .*\n  fix: put the file, SHA-256 [0-9a-f]{64}, into ")


if __name__ == "__main__":
    tap_runner.main()
