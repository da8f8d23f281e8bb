#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Packs the build as a wheel, installs that into a virtual environment without a network, and uses it there with nothing else of
Weir in reach."""

import base64
import csv
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

import tap_runner

SOURCE, BUILD = pathlib.Path(os.environ["WEIR_SOURCE"]), pathlib.Path(os.environ["WEIR_BUILD"])
WORK = tempfile.TemporaryDirectory()
FOLDER = pathlib.Path(WORK.name)
# Of this process, what leads to the build is left out.
BARE = {name: value for name, value in os.environ.items() if not name.startswith(("WEIR_", "GST_", "PYTHON", "LD_", "XDG_"))}
SHOWS = """
import sys, weir, nnstreamer_python, numpy
print(weir.__version__, nnstreamer_python.TensorShape is weir.TensorShape)
text = "videotestsrc num-buffers=2 ! video/x-raw,format=RGB,width=8,height=4 ! tensor_converter ! {} ! tensor_sink"
for frame in weir.Pipeline(text.format(sys.argv[1])).frames(timeout=60):
    print(frame[0].shape, int(frame[0].max()))
"""


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, **more)


def setUpModule():
    done = run(sys.executable, SOURCE / "tools" / "wheel", BUILD, FOLDER / "dist")
    assert done.returncode == 0, done.stdout + done.stderr
    global WHEEL
    WHEEL = pathlib.Path(done.stdout.strip())
    assert run(sys.executable, "-m", "venv", "--system-site-packages", FOLDER / "env").returncode == 0
    done = run(FOLDER / "env/bin/pip", "install", "--no-index", "--no-cache-dir", WHEEL, env=BARE)
    assert done.returncode == 0, done.stdout + done.stderr


class Wheel(unittest.TestCase):
    def program(self, *arguments, **more):
        done = run(FOLDER / "env/bin/python", "-c", *arguments, cwd=FOLDER,
                   env={**BARE, "GST_REGISTRY": str(FOLDER / "registry.bin"), "WEIR_CONFIG": "", **more})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def test_plays_pipelines(self):
        self.assertEqual(self.program(SHOWS, "tensor_transform mode=clamp option=7:9"),
                         ["3.0.0 True", "(1, 4, 8, 3) 9", "(1, 4, 8, 3) 9"])

    def test_finds_its_modules_and_its_worker(self):
        script = SOURCE / "src/modules/engines/python3/passthrough.py"
        for isolate in ("none", "process"):
            shown = self.program(SHOWS, f"tensor_filter framework=python3 model={script} isolate={isolate}")
            self.assertEqual([line.split(") ")[0] for line in shown[1:]], ["(1, 4, 8, 3"] * 2)

    def test_comes_from_the_environment_alone(self):
        shown = self.program("import os, weir; print(weir.__file__); print(open('/proc/self/maps').read())")
        self.assertTrue(shown[0].startswith(str(FOLDER / "env")), shown[0])
        self.assertEqual([line for line in shown if "libweir" in line and str(FOLDER) not in line], [])

    def test_keeps_what_the_user_has_set(self):
        shown = self.program("import os, weir; print(os.environ['WEIR_CARD_PATH']); print(os.environ['GST_PLUGIN_PATH'])",
                             WEIR_CARD_PATH="/my/cards", GST_PLUGIN_PATH="/my/plugins")
        self.assertEqual(shown[0], "/my/cards")
        self.assertRegex(shown[1], r"/bundle/lib/.*gstreamer-1.0:/my/plugins$")

    def test_says_what_it_needs(self):
        shown = run(FOLDER / "env/bin/pip", "show", "--verbose", "weir", env=BARE).stdout
        self.assertIn("Requires: numpy\n", shown)
        with zipfile.ZipFile(WHEEL) as wheel:
            text = wheel.read("weir-3.0.0.dist-info/METADATA").decode()
        self.assertIn("Requires-External: GStreamer (>=1.22)\n", text)
        self.assertIn("apt-get install gstreamer1.0-plugins-base", text)

    def test_lists_every_file_with_its_digest(self):
        with zipfile.ZipFile(WHEEL) as wheel:
            rows = list(csv.reader(wheel.read("weir-3.0.0.dist-info/RECORD").decode().splitlines()))
            self.assertEqual(sorted(row[0] for row in rows), sorted(wheel.namelist()))
            for name, listed, size in rows:
                if listed:
                    data = wheel.read(name)
                    wanted = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                    self.assertEqual((listed, int(size)), (f"sha256={wanted}", len(data)), name)


class Refusals(unittest.TestCase):
    def test_a_folder_that_is_no_build(self):
        done = run(sys.executable, SOURCE / "tools" / "wheel", FOLDER, FOLDER / "dist")
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"wheel: {FOLDER} is no build folder\n       make build makes the folder build\n"))


if __name__ == "__main__":
    if run(sys.executable, "-c", "import venv, ensurepip, pip").returncode:
        print("1..0 # SKIP python3-venv or python3-pip is not installed")
        sys.exit(0)
    tap_runner.main()
