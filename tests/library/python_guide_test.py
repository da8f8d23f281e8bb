#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs every program of docs/guide/python.md and compares what it prints with what the page says."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

try:
    import numpy as np
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
PAGE = (SOURCE / "docs" / "guide" / "python.md").read_text()
# (language, text) of each block in the order of the page.
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
PROGRAMS = [(text, BLOCKS[i + 1][1] if i + 1 < len(BLOCKS) and BLOCKS[i + 1][0] == "text" else None)
            for i, (language, text) in enumerate(BLOCKS) if language == "python" and "class CustomFilter" not in text]


def run(program, folder=SOURCE, env=None):
    return subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, timeout=120, check=False,
                          env=env)


class Guide(unittest.TestCase):
    def test_programs_run_and_print_what_the_page_shows(self):
        programs = [(text, shown) for text, shown in PROGRAMS if "clip.mp4" not in text]
        self.assertGreater(len(programs), 4)
        self.assertEqual(sum(shown is not None for _text, shown in programs), 1)
        for text, shown in programs:
            with self.subTest(text=text):
                if ".onnx\", threads" in text and not has_engine("onnxruntime"):
                    continue
                done = run(text)
                self.assertEqual(done.returncode, 0, done.stderr)
                if shown is not None:
                    self.assertEqual(done.stdout, shown)

    def test_the_objects_in_a_video(self):
        (text, shown), = [(text, shown) for text, shown in PROGRAMS if "clip.mp4" in text]
        model, clip = SHARED / "models/detection/yolox_nano.onnx", SHARED / "media/video/street_1080p25.mp4"
        if not has_engine("onnxruntime") or not model.exists() or not clip.exists():
            self.skipTest("the engine onnxruntime or the model is not there")
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            # The plug-ins of the machine, which decode videos: other tests use a few only.
            env = {key: value for key, value in os.environ.items() if key != "GST_PLUGIN_SYSTEM_PATH_1_0"}
            env.update(GST_REGISTRY=str(folder / "registry.bin"), WEIR_CARD_PATH=str(SOURCE / "models" / "cards"))
            for element in ("qtdemux", "avdec_h264"):
                if subprocess.run(["gst-inspect-1.0", "--exists", element], env=env, check=False).returncode:
                    self.skipTest(f"GStreamer has no {element} here")
            (folder / "yolox-nano").mkdir()
            (folder / "yolox-nano" / model.name).symlink_to(model.resolve())
            (folder / "clip.mp4").symlink_to(clip.resolve())
            text = text.replace("/usr/share/weir/cards", str(SOURCE / "models" / "cards"))
            text = text.replace(".frames():\n", ".frames():\n    if frame.pts > 200_000_000: break\n")
            done = run(text, folder, env)
        self.assertEqual(done.returncode, 0, done.stderr)
        # The numbers are those of another machine's floating point: they may differ in the last place.
        for line in shown.splitlines():
            numbers = [int(number) for number in re.findall(r"\d+", line)]
            near = [printed for printed in done.stdout.splitlines() if printed.split()[0] == line.split()[0]
                    and all(abs(int(a) - b) <= 2 for a, b in zip(re.findall(r"\d+", printed), numbers))]
            self.assertTrue(near, f"{line!r} is not in\n{done.stdout}")

    def test_the_filter_turns_pictures(self):
        script, = [text for language, text in BLOCKS if language == "python" and "class CustomFilter" in text]
        with tempfile.NamedTemporaryFile("w", suffix=".py") as file:
            file.write(script)
            file.flush()
            picture = np.arange(24, dtype=np.uint8).reshape(1, 2, 4, 3)
            np.testing.assert_array_equal(weir.Model(file.name)(picture)[0], picture[:, ::-1])

    def test_the_version(self):
        program = re.search(r"python3 -c '(.*)'", PAGE)[1]
        self.assertEqual(run(program).stdout, re.search(r"^This prints `(.*?)`\.", PAGE, re.MULTILINE)[1] + "\n")

    def test_the_table_has_every_member_of_a_result(self):
        rows = re.search(r"\| member \|.*?\n\n", PAGE, re.DOTALL)[0]
        named = {name for line in rows.strip().splitlines()[2:] for name in re.findall(r"`(\w+)`", line.split("|")[1])}
        self.assertEqual(named, set(weir.results.Row.__dataclass_fields__))


if __name__ == "__main__":
    tap_runner.main()
