#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""docs/guide/chains.md: two networks in one line read text that this test has drawn, and find the landmarks of a hand."""

import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
NPM = pathlib.Path(os.environ.get("WEIR_NPM_MODELS") or "/nonexistent")
MEDIA = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
FONT = next(iter(sorted(pathlib.Path("/usr/share/fonts/truetype").glob("*/*Sans*.ttf"))), None)
LINES = (("HELLO WORLD", (100, 100), 64), ("INVOICE 2024", (200, 350), 48))


def find(name):
    return next(iter(NPM.rglob(name)), None)


@unittest.skipUnless(find("ch_PP-OCRv4_det_infer.onnx") and find("ch_PP-OCRv4_rec_infer.onnx") and FONT,
                     "WEIR_NPM_MODELS has no PP-OCR models, or there is no font")
class Chains(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def draw(self):
        from PIL import Image, ImageDraw, ImageFont
        picture = Image.new("RGB", (960, 544), "white")
        for text, place, size in LINES:
            ImageDraw.Draw(picture).text(place, text, fill="black", font=ImageFont.truetype(str(FONT), size))
        picture.save(self.folder / "photo.png")

    def test_the_line_of_the_guide_reads_text(self):
        self.draw()
        text = (SOURCE / "docs/guide/chains.md").read_text()
        line = re.search(r"^gst-launch-1\.0 -q\n(?:  .*\n)+", text, re.M).group().replace("\n", " ")
        for name in ("ch_PP-OCRv4_det_infer.onnx", "ch_PP-OCRv4_rec_infer.onnx", "ppocr_keys_v1.txt"):
            line = re.sub(r"[\w.-]+/" + re.escape(name), shlex.quote(str(find(name))), line)
        line = line.replace("/usr/share/weir/cards", str(SOURCE / "models/cards"))
        line = line.replace("location=photo.png", f"location={self.folder}/photo.png")
        done = subprocess.run(line, shell=True, capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        frame = json.loads(done.stdout)
        self.assertEqual(frame["size"], [960, 544])
        self.assertEqual(len(frame["detections"]), 2)
        # The network often omits spaces.
        read = {item["text"].replace(" ", ""): item for item in frame["text"]}
        self.assertEqual(set(read), {text.replace(" ", "") for text, _, _ in LINES})
        for text, (x, y), size in LINES:
            item = read[text.replace(" ", "")]
            self.assertEqual(item["box"], frame["detections"][item["parent"]]["box"])
            self.assertLess(abs(item["box"][0] - x), 20)
            self.assertLess(abs(item["box"][1] - y), size / 2)
            self.assertGreater(item["score"], 0.8)


HAND, PALM = MEDIA / "media/image/hand_vsign.jpg", MEDIA / "models/detection/palm_detection_256_int8.tflite"


@unittest.skipUnless(find("hand_landmark_full.tflite") and HAND.is_file() and PALM.is_file(), "the models of hands or their picture are not here")
class Hands(unittest.TestCase):
    def test_the_line_of_the_guide_finds_the_hand(self):
        text = (SOURCE / "docs/guide/chains.md").read_text().split("## Hands")[1]
        line = re.search(r"^gst-launch-1\.0 -q\n(?:  .*\n)+", text, re.M).group().replace("\n", " ")
        line = line.replace("palm-detection/palm_detection_256_int8.tflite", str(PALM)).replace("/usr/share/weir/cards", str(SOURCE / "models/cards"))
        line = line.replace("hand_landmark_full.tflite", shlex.quote(str(find("hand_landmark_full.tflite")))).replace("hand.jpg", str(HAND))
        # The palm detector has the wrist and the root of the middle finger too.
        line = line.replace("! tensor_decoder mode=detection !", "! tensor_decoder mode=pose max-results=1 !")
        done = subprocess.run(line, shell=True, capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        palm, hand = json.loads(done.stdout)["detections"]
        self.assertEqual(hand["parent"], 0)
        self.assertGreater(hand["score"], 0.9)
        side = max(palm["box"][2] - palm["box"][0], palm["box"][3] - palm["box"][1])
        for of_palm, of_hand in ((0, 0), (2, 9), (1, 5), (4, 17)):
            place, wanted = hand["keypoints"][of_hand], palm["keypoints"][of_palm]
            self.assertLess(max(abs(place[i] - wanted[i]) for i in (0, 1)), side / 3, (of_palm, of_hand))


if __name__ == "__main__":
    tap_runner.main()
