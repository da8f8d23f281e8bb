#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""`meson devenv`: before anything is installed, the commands of the guides work from the build folder."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
NAMES = ("GST_PLUGIN_PATH", "GST_REGISTRY", "PYTHONPATH", "WEIR_COMMAND", "WEIR_MODULE_PATH", "WEIR_WORKER")


class BuildFolder(unittest.TestCase):
    def run_there(self, *command):
        with tempfile.TemporaryDirectory() as home:
            env = {name: value for name, value in os.environ.items() if name not in NAMES}
            env |= {"GST_REGISTRY": home + "/registry.bin", "GST_TRACERS": "", "GST_DEBUG": ""}
            return subprocess.run(["meson", "devenv", "-C", os.environ["WEIR_BUILD"], "-w", str(SOURCE), *command], env=env,
                                  capture_output=True, text=True, timeout=200, check=False)

    def test_the_command_is_found_and_finds_the_plugin_and_the_modules(self):
        done = self.run_there("weir", "doctor")
        self.assertIn(str(pathlib.Path(os.environ["GST_PLUGIN_PATH"]) / "libgstweir.so"), done.stdout, done.stderr)
        self.assertIn("image_labeling", done.stdout, done.stderr)

    def test_a_model_runs_in_a_process_of_its_own(self):
        done = self.run_there("weir", "run", "filesrc location=/dev/zero blocksize=192 num-buffers=3 ! application/octet-stream ! "
                              "tensor_converter input-dim=3:8:8:1 input-type=uint8 ! tensor_filter isolate=process "
                              "model=src/modules/engines/lua/halves.lua ! fakesink")
        if "apt-get install libluajit" in done.stderr:
            self.skipTest("LuaJIT is missing")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    tap_runner.main()
