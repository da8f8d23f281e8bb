#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Segments and finds key points in photos of ../shared and compares the drawn pictures with published results.

A published mask gives the class of each pixel. Key points are computed again with NumPy from the tensors of the
model, and compared with reference results that another program computed.
"""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import tap_runner

try:
    import numpy as np
except ImportError:
    np = None

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / ".." / "shared")
PHOTOS = SHARED / "media" / "image"
SEGMENTATION = SHARED / "models" / "segmentation" / "deeplabv3_257_mv_gpu.tflite"
POSE = SHARED / "models" / "pose" / "posenet_mobilenet_v1_075_353_481_quant.tflite"
BODY = ["nose 0", "left_eye 1", "right_eye 2", "left_ear 3", "right_ear 4", "left_shoulder 5", "right_shoulder 6",
        "left_elbow 7", "right_elbow 8", "left_wrist 9", "right_wrist 10", "left_hip 11", "right_hip 12", "left_knee 13",
        "right_knee 14", "left_ankle 15", "right_ankle 16"]  # each point is its own line: a dot


def missing(model, photo):
    if np is None:
        return "NumPy is not installed"
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

    @unittest.skipIf(missing(POSE, "posenet_couple.jpg"), missing(POSE, "posenet_couple.jpg"))
    def test_key_points_are_where_the_reference_has_them(self):
        with tempfile.TemporaryDirectory() as folder:
            body, tensors, out = (pathlib.Path(folder) / name for name in ("body", "tensors", "out"))
            body.write_text("\n".join(BODY) + "\n")
            done = play("posenet_couple.jpg",
                        f'tensor_preprocess width=481 height=353 type=uint8 ! tensor_filter model="{POSE}" '
                        "output-combination=o0,o1 ! tensor_transform mode=arithmetic "
                        "option=typecast:float32,add:-128,mul:0.0784314 ! tee name=t ! queue ! "
                        f"filesink location={tensors} t. ! queue ! tensor_decoder mode=pose_estimation "
                        f"option1=1920:1278 option2=481:353 option3={body} option4=heatmap-offset ! "
                        f"filesink location={out}")
            self.assertEqual(done.returncode, 0, done.stderr)
            values = np.fromfile(tensors, "<f4")
            pixels = np.fromfile(out, "<u4").reshape(1278, 1920)
        heat = values[:23 * 31 * 17].reshape(23, 31, 17)
        offsets = values[23 * 31 * 17:].reshape(23, 31, 34)
        reference = json.loads((SHARED / "media" / "reference_results.json").read_text())["pose"]["posenet_couple.jpg"]
        reference = next(points for name, points in reference.items() if name.startswith("posenet"))
        found = 0
        for index, line in enumerate(BODY):
            name = line.split()[0]
            row, column = np.unravel_index(heat[:, :, index].argmax(), (23, 31))
            if 1 / (1 + np.exp(-heat[row, column, index])) < 0.5:
                continue
            found += 1
            x = np.float32(column) / np.float32(30) * np.float32(481) + offsets[row, column, 17 + index]
            y = np.float32(row) / np.float32(22) * np.float32(353) + offsets[row, column, index]
            x, y = int(x * np.float32(1920) / np.float32(481)), int(y * np.float32(1278) / np.float32(353))
            # Two steps of the model's input; grids of reference implementations differ by its stride.
            self.assertLess(np.hypot(x - reference[name][0], y - reference[name][1]), 16, name)
            # The name covers rows above the point; the lower half of the dot is in the picture.
            for dy in range(1, 5):
                for dx in range(dy - 4, 5 - dy):
                    self.assertEqual(pixels[y + dy, x + dx], 0xFFFFFFFF, f"{name} {dx},{dy}")
        self.assertEqual(found, 17)


if __name__ == "__main__":
    tap_runner.main()
