# SPDX-License-Identifier: LGPL-2.1-or-later
"""Helpers shared by the tests of the command `weir`."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

COMMAND = os.environ["WEIR_COMMAND"]
PLUGIN = pathlib.Path(os.environ["WEIR_PLUGIN"])
SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
DECOY = pathlib.Path(os.environ["WEIR_DECOY"])
MODEL = SOURCE / "models" / "clock_digits.onnx"
HAS_ONNX = "onnxruntime" in os.environ["WEIR_MODULE_PATH"]
SANITIZED = os.environ["WEIR_SANITIZED"] != "none"


def sanitized():
    """With GCC 12 and glibc 2.36 the search for leaks sometimes crashes in thread-local memory of libraries that were unloaded."""
    if not SANITIZED:
        return {}
    return {"ASAN_OPTIONS": f"{os.environ.get('ASAN_OPTIONS', '')}:intercept_tls_get_addr=0".lstrip(":")}


def weir(*arguments, **environment):
    """Runs the command without a terminal and checks that it prints no terminal control characters."""
    done = subprocess.run([COMMAND, *map(str, arguments)], env={**os.environ, **sanitized(), **environment}, cwd=SOURCE, timeout=300,
                          text=True, capture_output=True, stdin=subprocess.DEVNULL)
    assert not re.search(r"[\033\r\b]", done.stdout + done.stderr), repr(done)
    return done


# The first process scans all plug-ins of the system into the registry; their leaks are not ours.
if SANITIZED:
    weir("doctor", ASAN_OPTIONS="detect_leaks=0")


# Environment for processes that are not checked for leaks. LeakSanitizer of GCC 12 mistakes a
# library's thread-local block that begins 16 bytes into a page for one of an older glibc, and its
# tracer then reads unmapped memory (LSAN_OPTIONS=verbosity=1:log_threads=1 shows it at an address
# like 0x48d9). Whether this happens depends on which libraries are loaded, and in which order.
WITHOUT_LEAKS = {"ASAN_OPTIONS": ":".join(filter(None, (os.environ.get("ASAN_OPTIONS"), "detect_leaks=0")))} if SANITIZED else {}


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def good(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def run_for(self, seconds, *words):
        """Ends a live pipeline by --timeout, after so many seconds or, when it does not start in that time, after more."""
        while True:
            done = weir("run", "--timeout", seconds, *words)
            if seconds > 60 or "the pipeline did not reach PLAYING" not in done.stdout + done.stderr:
                return done
            seconds *= 4

    def downloaded(self, name):
        """A file with the name, the size and the place of a model of the catalogue, for WEIR_MODELS=self.folder. Not that model's bytes."""
        catalogue = json.loads((SOURCE / "models" / "catalogue.json").read_text())
        file = next(model for model in catalogue["models"] if model["name"] == name)["files"][0]
        path = self.folder / name / file["name"]
        path.parent.mkdir()
        path.write_bytes(MODEL.read_bytes().ljust(file["bytes"], b"\0")[:file["bytes"]])
        return path

    def runs(self, line, **environment):
        """Runs a shell command. gst-launch-1.0 cannot load a plug-in that is built with a sanitizer."""
        if SANITIZED:
            line = re.sub(r"^gst-launch-1\.0 ", f"{COMMAND} run ", line)
        self.good(subprocess.run(["bash", "-c", line], cwd=SOURCE, env={**os.environ, **environment}, capture_output=True,
                                 text=True, timeout=60))

    def refused(self, done, code, *texts):
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        for arguments in texts:
            self.assertIn(arguments, done.stdout + done.stderr)

    def plugins_of(self, *folders):
        """Environment for a GStreamer that finds only the plug-ins of these folders and scans them again."""
        return {**WITHOUT_LEAKS, "GST_PLUGIN_PATH": ":".join(map(str, folders)), "GST_PLUGIN_SYSTEM_PATH_1_0": str(self.folder / "none"),
                "GST_REGISTRY": str(self.folder / f"registry-{folders[0].name}")}
