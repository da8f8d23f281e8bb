#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Segments, finds key points and cuts out objects in photos of ../shared and compares the pictures with published results.

A published mask gives the class of each pixel. Key points are computed again with NumPy from the tensors of the
model, drawn with NumPy, and compared with published places and with reference results that another program computed.
"""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import picture_decoders_reference
import tap_runner
from drawing_reference import WHITE, Glyphs

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / ".." / "shared")
PHOTOS = SHARED / "media" / "image"
SEGMENTATION = SHARED / "models" / "segmentation" / "deeplabv3_257_mv_gpu.tflite"
POSE = SHARED / "models" / "pose" / "posenet_mobilenet_v1_075_353_481_quant.tflite"
SSD = SHARED / "models" / "detection" / "ssd_mobilenet_v1_raw_uint8.tflite"
VIDEO = "../video/pose_1.mp4"
# Each point is connected with itself only, which draws a dot.
BODY = [(name, [k]) for k, name in enumerate(["nose"] + [f"{side}_{part}" for part in (
    "eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle") for side in ("left", "right")])]


def missing(model, photo):
    for path in (model, PHOTOS / photo):
        if not path.exists():
            return f"{path.name} is not there"
    return None if "tensorflow-lite" in os.environ["WEIR_MODULE_PATH"] else "the engine tensorflow-lite is not built"


def play(photo, rest):
    line = f'filesrc location="{PHOTOS / photo}" ! decodebin ! videoconvert ! video/x-raw,format=RGB ! {rest}'
    return subprocess.run(["bash", "-c", "exec gst-launch-1.0 -q " + line.replace(" ! ", " '!' ")], timeout=120,
                          capture_output=True, text=True, stdin=subprocess.DEVNULL)


def png(path):
    """The gray levels of a PNG file, by GStreamer."""
    with tempfile.NamedTemporaryFile() as raw:
        subprocess.run(["gst-launch-1.0", "-q", "filesrc", f"location={path}", "!", "pngdec", "!", "videoconvert", "!",
                        "video/x-raw,format=RGB", "!", "filesink", f"location={raw.name}"], timeout=60, check=True,
                       capture_output=True)
        return np.fromfile(raw.name, np.uint8)


class DrawnPictures(unittest.TestCase):
    @unittest.skipIf(missing(SEGMENTATION, "segmentation_input.jpg"), missing(SEGMENTATION, "segmentation_input.jpg"))
    def test_classes_are_those_of_the_published_mask(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            done = play("segmentation_input.jpg",
                        "tensor_preprocess width=257 height=257 type=float32 mean=127.5 scale=0.00784313725 ! "
                        f'tensor_filter model="{SEGMENTATION}" ! '
                        f"tensor_decoder mode=image_segment option1=tflite-deeplab ! filesink location={out}")
            self.assertEqual(done.returncode, 0, done.stderr)
            ours = np.fromfile(out, "<u4")
        colors = {0 if i == 0 else 0xFFFFFF // 21 * i | 0xFF000000: i for i in range(21)}
        classes = np.array([colors[int(color)] for color in ours]).reshape(257, 257)
        mask = png(PHOTOS / "segmentation_golden.png")
        # Rows of RGB are padded to four bytes; the mask holds ten times the class.
        published = mask.reshape(257, -1)[:, :3 * 257:3] // 10
        self.assertGreater((classes == published).mean(), 0.99)
        shares = json.loads((SHARED / "media" / "reference_results.json").read_text())["segmentation"]
        expected = shares["segmentation_input.jpg"]["pixel_share_257"]
        for name, index in (("background", 0), ("horse", 13), ("person", 15)):
            self.assertAlmostEqual((classes == index).mean(), expected[name], delta=0.01, msg=name)

    def joints(self, source, output, option2, mode):
        """The key points by name. The picture is compared with NumPy's, which is drawn from the same tensors."""
        with tempfile.TemporaryDirectory() as folder:
            body, tensors, out = (pathlib.Path(folder) / name for name in ("body", "tensors", "out"))
            body.write_text("\n".join(f"{name} {k}" for name, (k,) in BODY) + "\n")
            done = play(source, f'tensor_preprocess width=481 height=353 type=uint8 ! tensor_filter model="{POSE}" '
                        "output-combination=o0,o1 ! tensor_transform mode=arithmetic "
                        "option=typecast:float32,add:-128,mul:0.0784314 ! tee name=t ! queue ! "
                        f"filesink location={tensors} t. ! queue ! tensor_decoder mode=pose_estimation "
                        f"option1={output[0]}:{output[1]} option2={option2} option3={body} option4={mode} ! filesink location={out}")
            self.assertEqual(done.returncode, 0, done.stderr)
            heat, offsets = np.split(np.fromfile(tensors, "<f4", 23 * 31 * 3 * 17), [23 * 31 * 17])
            drawn = np.fromfile(out, "u1", 4 * output[0] * output[1]).reshape(output[1], output[0], 4)
        heat, offsets = heat.reshape(23, 31, 17), offsets.reshape(23, 31, 34)
        places = picture_decoders_reference.joints(heat, output, [int(n) for n in option2.split(":")],
                                                   *[offsets] * (mode == "heatmap-offset"))
        Glyphs(WHITE).compare(drawn, picture_decoders_reference.draw_pose(places, output, BODY))
        return {name: place for (name, _), place in zip(BODY, places)}

    @unittest.skipIf(missing(POSE, "posenet_couple.jpg"), missing(POSE, "posenet_couple.jpg"))
    def test_key_points_are_where_the_reference_has_them(self):
        reference = json.loads((SHARED / "media" / "reference_results.json").read_text())["pose"]["posenet_couple.jpg"]
        reference = next(points for name, points in reference.items() if name.startswith("posenet"))
        # Two steps of the model's input, since grids of reference implementations differ by its stride. Without offsets: a
        # cell and a half of 31 in a row, since the cells' left edges are drawn.
        for mode, option2, off in (("heatmap-offset", "481:353", 16), ("heatmap-only", "31:23", 93)):
            with self.subTest(mode):
                found = self.joints("posenet_couple.jpg", (1920, 1278), option2, mode)
                for name, (x, y, _) in reference.items():
                    self.assertLess(np.hypot(found[name][0] - x, found[name][1] - y), off, name)

    @unittest.skipIf(missing(POSE, VIDEO), missing(POSE, VIDEO))
    def test_key_points_of_a_video_are_the_published_ones(self):
        published = json.loads((SHARED / "media" / "video" / "pose_1.json").read_text())[0]
        found = self.joints(VIDEO, (576, 576), "481:353", "heatmap-offset")
        seen = {name: place for name, place in published.items() if found[name]}
        self.assertGreater(len(seen), 8)
        for name in ("nose", "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_hip", "right_hip"):
            # MANIFEST.md: at most 14.8 pixels with one program's resampler.
            self.assertLess(np.hypot(found[name][0] - seen[name]["x"], found[name][1] - seen[name]["y"]), 20, name)

    @unittest.skipIf(missing(SSD, "cats_and_dogs.jpg"), missing(SSD, "cats_and_dogs.jpg"))
    def test_the_objects_that_a_detector_finds_are_cut_out(self):
        """tensor_region takes the first class over the threshold; at 0.5 only one class of an anchor is over it."""
        with tempfile.TemporaryDirectory() as folder:
            out, picture = pathlib.Path(folder) / "out", pathlib.Path(folder) / "picture"
            done = play("cats_and_dogs.jpg",
                        "videoscale method=bilinear add-borders=false ! video/x-raw,width=300,height=300,pixel-aspect-ratio=1/1 ! "
                        f'tensor_converter ! tee name=t ! queue ! tensor_filter model="{SSD}" ! tensor_demux name=d '
                        "d.src_0 ! queue ! tensor_transform mode=arithmetic option=typecast:float32,add:-191,mul:0.0790279 ! m.sink_0 "
                        "d.src_1 ! queue ! tensor_transform mode=arithmetic option=typecast:float32,add:-223,mul:0.0497368 ! m.sink_1 "
                        "tensor_mux name=m ! tensor_decoder mode=tensor_region option1=3 "
                        f'option2="{SSD.parent / "coco_labels_list.txt"}" option3="{SSD.parent / "box_priors.txt"}:0.54" ! c.info '
                        f"t. ! queue ! c.raw t. ! queue ! filesink location={picture} tensor_crop name=c ! filesink location={out}")
            self.assertEqual(done.returncode, 0, done.stderr)
            pixels, parts = np.fromfile(picture, "u1").reshape(300, 300, 3), out.read_bytes()
        published = json.loads((SHARED / "media" / "reference_results.json").read_text())["detection"]["cats_and_dogs.jpg"]
        for name, _, box in published["ssd_raw_with_priors"][:3]:
            width, height = np.frombuffer(parts, "<u4", 2, 16)
            part = np.frombuffer(parts, "u1", 3 * width * height, 128).reshape(height, width, 3)
            parts = parts[128 + part.size:]
            x, y, right, bottom = np.array(box) / ([4, 2] * 2)
            places = [(a, b) for a in range(300 - width + 1) for b in range(300 - height + 1)
                      if (pixels[b, a] == part[0, 0]).all() and (pixels[b:b + height, a:a + width] == part).all()]
            self.assertEqual(len(places), 1, name)
            (a, b), = places
            # 10 pixels of the photo by MANIFEST.md and one of the model's input.
            self.assertLess(np.abs(np.array([a - x, b - y, a + width - right, b + height - bottom]) * [4, 2, 4, 2]).max(), 14, name)
        self.assertEqual(parts, b"")


if __name__ == "__main__":
    tap_runner.main()
