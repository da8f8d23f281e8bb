#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A Python program plays a pipeline with a script: both run in the same interpreter."""

import os
import pathlib
import subprocess
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
PROGRAM = """
import threading, gi
gi.require_version("Gst", "1.0")
from gi.repository import Gst
Gst.init(None)
pipeline = Gst.parse_launch("filesrc location=/dev/zero blocksize=64 num-buffers=5 ! application/octet-stream ! "
    "tensor_converter name=c mode=custom-script:src/modules/converters/python3/histogram.py ! fakesink")
busy = threading.Event()
threading.Thread(target=lambda: [None for _ in iter(busy.is_set, True)], daemon=True).start()
pipeline.set_state(Gst.State.PLAYING)
message = pipeline.get_bus().timed_pop_filtered(60 * Gst.SECOND, Gst.MessageType.ERROR | Gst.MessageType.EOS)
print(message.parse_error() if message.type == Gst.MessageType.ERROR else "end")
print(pipeline.get_by_name("c").get_property("stats").get_uint64("consumed")[1])
busy.set()
pipeline.set_state(Gst.State.NULL)
"""


class PythonProgram(unittest.TestCase):
    def test_shares_its_interpreter_with_a_script(self):
        lacking = subprocess.run(["/usr/bin/python3", "-c", "import gi, numpy; gi.require_version('Gst', '1.0')"],
                                 capture_output=True, text=True, check=False)
        if lacking.returncode:
            self.skipTest("python3-gi, gir1.2-gst-plugins-base-1.0 or python3-numpy is missing")
        env = {**os.environ, "GST_TRACERS": "", "GST_DEBUG": ""}
        done = subprocess.run(["/usr/bin/python3", "-c", PROGRAM], capture_output=True, text=True, timeout=120, env=env,
                              cwd=SOURCE, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, "end\n5\n")


if __name__ == "__main__":
    tap_runner.main()
