#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs pictures of ../shared in TensorFlow Lite and in the lowered graph, from the same decoder.

Compares every value: the class is the same, and no difference exceeds the one in docs/guide/lowering.md.
"""

import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / ".." / "shared")
CLASSIFIERS = SHARED / "models" / "classification"
CENTRED = ("tensor_transform mode=arithmetic option=typecast:int16,add:-128 ! "
           "tensor_transform mode=typecast option=int8 ! ")
# model, width and height, preparation of its input, number of pictures or None for all, tolerance
# in steps
MODELS = [(CLASSIFIERS / "mobilenet_v2_1.0_224_quant.tflite", (224, 224), "", None, 4),
          (CLASSIFIERS / "mobilenet_v1_0.25_224_quant.tflite", (224, 224), "", 2, 1),
          (CLASSIFIERS / "mobilenet_v1_0.75_192_quant.tflite", (192, 192), "", 2, 1),
          (SHARED / "models/detection/ssd_mobilenet_v1_raw_uint8.tflite", (300, 300), "", 1, 1),
          (SHARED / "models/pose/posenet_mobilenet_v1_075_353_481_quant.tflite", (481, 353), "", 8, 4),
          (CLASSIFIERS / "resnet8_cifar10_int8.tflite", (32, 32), CENTRED, 2, 1),
          (CLASSIFIERS / "vww_96_int8.tflite", (96, 96), CENTRED, 2, 1)]


def missing():
    if not CLASSIFIERS.is_dir():
        return "the real models are not there"
    lacking = [e for e in ("onnxruntime", "tensorflow-lite") if e not in os.environ["WEIR_MODULE_PATH"]]
    return f"the engine {lacking[0]} is not built" if lacking else None


def pictures():
    media = SHARED / "media"
    return sorted([*media.glob("image/*.jpg"), *media.glob("image/*.png"), *media.glob("face/*.jpg")])


@unittest.skipIf(missing(), missing())
class Lowering(unittest.TestCase):
    def both(self, picture, model, size, preparation):
        """The output bytes of TensorFlow Lite and of the lowered graph."""
        tflite = f'tensor_filter framework=tensorflow-lite model="{model}" custom='
        with tempfile.TemporaryDirectory() as folder:
            own, lowered = (pathlib.Path(folder) / name for name in ("own", "lowered"))
            line = (f'filesrc location="{picture}" ! decodebin ! videoconvert ! videoscale ! '
                    f"video/x-raw,format=RGB,width={size[0]},height={size[1]} ! tensor_converter ! {preparation}tee name=t ! "
                    f"queue ! {tflite}Lowering:None ! filesink location={own} "
                    f"t. ! queue ! {tflite}Lowering:onnxruntime ! filesink location={lowered}")
            done = subprocess.run(["bash", "-c", "exec gst-launch-1.0 -q " + line.replace(" ! ", " '!' ")], timeout=120,
                                  capture_output=True, text=True, stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+")
            self.assertNotIn("TensorFlow Lite runs it", done.stderr)
            return own.read_bytes(), lowered.read_bytes()

    def test_pictures_give_the_same_class_and_close_values(self):
        for model, size, preparation, count, steps in MODELS:
            for picture in pictures()[:count]:
                with self.subTest(model=model.name, picture=picture.name):
                    own, lowered = self.both(picture, model, size, preparation)
                    self.assertEqual(len(own), len(lowered))
                    if preparation:  # int8
                        own, lowered = (bytes(value ^ 0x80 for value in values) for values in (own, lowered))
                    self.assertEqual(own.index(max(own)), lowered.index(max(lowered)))
                    self.assertLessEqual(max(abs(a - b) for a, b in zip(own, lowered)), steps)

    def test_movenet_finds_the_same_places(self):
        """Compares the points of which TensorFlow Lite is certain; its grid has 48 places."""
        model = SHARED / "models/pose/movenet_lightning_ptq.tflite"
        for name in ("face/obama-1080p.jpg", "face/ivan.jpg", "image/posenet_couple.jpg"):
            with self.subTest(picture=name):
                own, lowered = (struct.unpack("51f", values) for values in self.both(SHARED / "media" / name, model, (192, 192), ""))
                sure = [i for i in range(0, 51, 3) if own[i + 2] > 0.4]
                self.assertGreater(len(sure), 5)
                for i in sure:
                    self.assertLess(max(abs(own[i] - lowered[i]), abs(own[i + 1] - lowered[i + 1])), 1.5 / 48)


if __name__ == "__main__":
    tap_runner.main()
