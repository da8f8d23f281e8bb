#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that GST_DEBUG shows what documents, errors and man pages promise."""

import fnmatch
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
LINE = re.compile(r"^\S+ +\d+ +\S+ +(ERROR|WARN|INFO|DEBUG|LOG) +(\S+) (\S+:\d+:\S+ .*)$", re.MULTILINE)
# The caps have no format, about which the library warns; the filter is a script.
PIPELINE = ("filesrc location=/dev/zero blocksize=192 num-buffers=3 ! application/octet-stream,framerate=10/1 ! "
            "tensor_converter input-dim=3:8:8:1 input-type=uint8 ! "
            "tensor_filter model=src/modules/engines/lua/halves.lua ! fakesink")
# For categories that log nothing in that pipeline.
EDGESINK = "videotestsrc num-buffers=3 ! edgesink host=0.0.0.0 port=0"  # it warns, because others can connect
OTHER_PIPELINES = {
    "edgesink:2": EDGESINK,
    "edgesink:4": EDGESINK,
    "weir-bounding_boxes:4":
        "filesrc location=/dev/zero blocksize=5600 num-buffers=3 ! application/octet-stream,framerate=10/1 ! "
        "tensor_converter input-dim=7:200 input-type=float32 ! "
        "tensor_decoder mode=bounding_boxes option1=ov-person-detection option4=64:48 option5=64:48 option7=1 ! fakesink",
}
# tests/compat plays the first, inference_server_test.py the second; query_server_test.py and query_offload_test.py read the sums of the others.
OF_OTHER_TESTS = {"weir-nnstreamer:5", "weir-oip:4", "tensor_query_serversrc:4", "tensor_query_client:4"}


def promised():
    """Each value of GST_DEBUG in a text for users."""
    found = set()
    files = [*SOURCE.glob("*.md"), *(f for folder in ("apps", "docs", "examples", "include", "src") for f in (SOURCE / folder).rglob("*"))]
    for file in files:
        if file.suffix in (".cpp", ".hpp", ".h", ".md", ".1") and "_test" not in file.name:
            found |= set(re.findall(r"GST_DEBUG=([\w*:,-]*\w)", file.read_text(encoding="utf-8")))
    return found


class Log(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        # A setting that does not exist: the library warns of it.
        (pathlib.Path(self.folder.name) / "weir.ini").write_text("[filter]\nnonsense = 1\n", encoding="utf-8")

    def tearDown(self):
        self.folder.cleanup()

    def play(self, value, line=PIPELINE):
        done = subprocess.run(["gst-launch-1.0", *line.split()], cwd=SOURCE, timeout=120, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, env={**os.environ, "GST_DEBUG": value, "GST_TRACERS": "",
                                                             "WEIR_CONFIG": self.folder.name + "/weir.ini"})
        if "apt-get install libluajit" in done.stderr:
            self.skipTest("LuaJIT is missing")
        return done.returncode, LINE.findall(done.stderr)

    def test_each_promised_value_shows_lines(self):
        values = promised() - OF_OTHER_TESTS
        self.assertGreater(len(values), 2)
        for value in sorted(values):
            with self.subTest(value):
                pattern = value.partition(":")[0] if ":" in value else "*"
                status, lines = self.play(value, OTHER_PIPELINES.get(value, PIPELINE))
                self.assertEqual(status, 0)
                self.assertTrue([line for line in lines if fnmatch.fnmatch(line[1], pattern)], lines)

    def test_info_names_what_was_chosen(self):
        status, lines = self.play("tensor_*:4")
        self.assertEqual(status, 0)
        output = [text for level, category, text in lines if (level, category) == ("INFO", "tensor_filter")]
        text = "\n".join(output)
        self.assertRegex(text, r"framework=auto selected lua: the file has the extension \.lua")
        self.assertRegex(text, r"model src/modules/engines/lua/halves\.lua: engine lua, 1 workers with \d+ threads each")
        self.assertRegex(text, r"input caps .*3:8:8:1")
        self.assertRegex(text, r"output caps other/tensor, dimension=\(string\)3:8:8:1, type=\(string\)float32")
        self.assertFalse([line for line in lines if line[0] in ("DEBUG", "LOG")])

    def test_each_frame_is_a_line_of_level_log(self):
        _, lines = self.play("tensor_filter:6")
        self.assertEqual(sum(level == "LOG" and category == "tensor_filter" for level, category, _ in lines), 3)

    def test_an_error_is_logged_with_its_element(self):
        status, lines = self.play("1", "videotestsrc num-buffers=1 ! tensor_converter ! tensor_filter name=net model=none.lua ! fakesink")
        self.assertNotEqual(status, 0)
        self.assertTrue([line for line in lines if line[:2] == ("ERROR", "tensor_filter") and "<net>" in line[2]
                         and "WEIR-3003" in line[2]], lines)


if __name__ == "__main__":
    tap_runner.main()
