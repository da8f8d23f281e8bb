#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests examples/offload: boxes go on when a server is killed, every request has an end, and what it refuses."""

import json
import os
import pathlib
import subprocess
import unittest

import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
OFFLOAD = SOURCE / "examples/offload/offload"
CLIP = SHARED / "media/video/street_1080p25.mp4"
MODEL = SHARED / "models/detection/yolox_nano.onnx"


def offload(*options):
    path = f"{pathlib.Path(os.environ['WEIR_COMMAND']).parent}:{os.environ['PATH']}"
    environment = {name: value for name, value in os.environ.items() if name not in ("GST_TRACERS", "GST_DEBUG")}
    return subprocess.run([OFFLOAD, *map(str, options)], env={**environment, "PATH": path}, capture_output=True, text=True, timeout=120)


class Offload(unittest.TestCase):
    def test_what_is_missing_is_named(self):
        done = offload("/nowhere.mp4")
        self.assertEqual((done.returncode, done.stderr), (1, "offload: /nowhere.mp4: there is no such file\n  fix: a video\n"))
        done = offload(__file__, "--model", "/nowhere.onnx")
        self.assertEqual(done.returncode, 1)
        self.assertIn("offload: /nowhere.onnx: there is no such file\n  fix: weir models get yolox-nano, or --model FILE", done.stderr)

    @unittest.skipUnless(CLIP.exists() and MODEL.exists(), "no clip or no model (WEIR_DATA)")
    @unittest.skipUnless(has_engine("onnxruntime"), "the engine onnxruntime is not built")
    def test_boxes_go_on_within_a_second_when_a_server_is_killed(self):
        done = offload(CLIP, "--model", MODEL, "--kill-after", "1.5", "--timeout-ms", "5000", "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("1.5 s: server 1 was killed\n", done.stdout)
        facts = json.loads(done.stdout.splitlines()[-1])
        self.assertLess(facts["wait"], 1)
        self.assertGreater(facts["results"], 10)
        self.assertEqual(facts["sent"], facts["answered"] + facts["late"] + facts["refused"] + facts["lost"])
        self.assertEqual(facts["lost"], 0, "the other server gets the requests of the one that was killed")
        self.assertEqual(facts["results"], facts["answered"])

    @unittest.skipUnless(CLIP.exists() and has_engine("onnxruntime"), "no clip (WEIR_DATA), or the engine onnxruntime is not built")
    def test_a_server_that_does_not_start_is_named(self):
        done = offload(CLIP, "--model", __file__)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"offload: weir serve {__file__} did not start", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
