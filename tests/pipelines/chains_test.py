#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""docs/guide/chains.md: two networks in one line read text that this test has drawn."""

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


if __name__ == "__main__":
    tap_runner.main()
