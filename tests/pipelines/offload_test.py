#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests examples/offload: what it refuses, and a real detector on two servers, one of which is killed."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
RUN = SOURCE / "examples/offload/run"
CLIP = SHARED / "media/video/street_1080p25.mp4"
MODEL = SHARED / "models/detection/yolox_nano.onnx"
NET = (pathlib.Path(os.environ["WEIR_BUILD"]) / "src/plugin/libgstweirnet.so").exists()


def run(*arguments):
    return subprocess.run([RUN, *map(str, arguments)], capture_output=True, text=True, timeout=400)


class Refusals(unittest.TestCase):
    def refused(self, text, *arguments):
        done = run(*arguments)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn(text, done.stderr)

    def test_files_that_do_not_exist(self):
        self.refused("run: /no/clip.mp4: there is no such video", "/no/clip.mp4")
        self.refused("run: /no/model.onnx: there is no such model\n  fix: weir models get yolox-nano", "--model", "/no/model.onnx", RUN)
        self.refused("run: /no/card.json: there is no such model card", "--model", RUN, "--card", "/no/card.json", RUN)

    def test_numbers_below_one(self):
        self.refused("run: --rate 0 is below 1", "--model", RUN, "--rate", 0, RUN)
        self.refused("run: --repeat -1 is below 1", "--model", RUN, "--repeat", -1, RUN)

    def test_words_that_are_missing(self):
        self.refused("the following arguments are required: VIDEO")

    @unittest.skipUnless(NET, "the plug-in weirnet is not built")
    def test_a_file_that_is_no_model(self):
        done = run("--model", RUN, RUN)
        self.assertEqual(done.returncode, 1)
        self.assertIn("run: the server did not start, see above", done.stderr)
        self.assertIn("WEIR-", done.stderr)


@unittest.skipUnless(NET and has_engine("oip") and has_engine("onnxruntime") and CLIP.exists() and MODEL.exists(),
                     "the plug-in weirnet, the engines oip and onnxruntime, the clip or the network is not here")
class Played(unittest.TestCase):
    def test_boxes_continue_when_a_server_is_killed(self):
        with tempfile.TemporaryDirectory() as folder:
            boxes = pathlib.Path(folder) / "boxes.jsonl"
            done = run("--model", MODEL, "--repeat", 2, "--kill-after", 5, "--max-gap", 30, "--boxes", boxes, CLIP)
            self.assertIn("is killed after 5 frames with results", done.stdout, done.stderr)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            frames = [json.loads(line) for line in boxes.read_text().splitlines()]
        self.assertGreater(len(frames), 10)
        # The clip is a street with at least four people in every frame.
        for frame in frames:
            self.assertGreaterEqual(sum(found["label"] == "person" for found in frame["detections"]), 4)
        sent, *ends = map(int, re.search(r"requests: (\d+) sent = (\d+) answered \+ (\d+) late \+ (\d+) refused \+ (\d+) lost",
                                         done.stdout).groups())
        self.assertEqual(sent, sum(ends))
        self.assertEqual(ends[0], len(frames))

    def test_a_clip_that_ends_before_the_kill(self):
        done = run("--model", MODEL, "--rate", 1, CLIP)
        self.assertEqual(done.returncode, 1)
        self.assertIn("the video has ended before 20 frames with results\n  fix: --repeat 2\n", done.stdout)


if __name__ == "__main__":
    tap_runner.main()
