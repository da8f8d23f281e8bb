#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests `gst-inspect-1.0 --exists`, which accepts an element only if its plug-in is at least of GStreamer's version."""

import os
import pathlib
import re
import subprocess
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
# The folder `tests` next to them contains no element.
ELEMENTS = sorted({path.parent.name for folder in ("elements", "edge", "net-elements") for path in SOURCE.glob(f"src/{folder}/*/README.md")}
                  - {"tests"})


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout


def exists(*arguments):
    quiet = {**os.environ, "GST_TRACERS": "", "GST_DEBUG": ""}
    return subprocess.run(["gst-inspect-1.0", "--exists", *arguments], env=quiet, capture_output=True, timeout=60,
                          check=False).returncode == 0


class GstInspect(unittest.TestCase):
    def test_every_element_exists(self):
        self.assertIn("tensor_converter", ELEMENTS)
        self.assertGreater(len(ELEMENTS), 20)
        self.assertEqual([name for name in ELEMENTS if not exists(name)], [])

    def test_every_element_is_of_a_version_that_scripts_ask_for(self):
        # This machine's GStreamer version, that of Debian 13, and Weir's.
        own = re.search(r"GStreamer (\d+\.\d+\.\d+)", output_of("gst-inspect-1.0", "--version"))[1]
        for version in (own, "1.26.0", "3.0.0"):
            with self.subTest(version):
                self.assertEqual([name for name in ELEMENTS if not exists(f"--atleast-version={version}", name)], [])

    def test_no_element_is_newer_than_weir(self):
        major, minor, micro = map(int, re.fullmatch(r"weir (\d+)\.(\d+)\.(\d+)\n",
                                                    output_of(os.environ["WEIR_COMMAND"], "--version")).groups())
        for version in (f"{major}.{minor}.{micro + 1}", f"{major}.{minor + 1}.0", f"{major + 1}.0.0"):
            with self.subTest(version):
                self.assertEqual([name for name in ELEMENTS if exists(f"--atleast-version={version}", name)], [])

    def test_every_element_names_its_page(self):
        for name in ELEMENTS:
            with self.subTest(name):
                link = re.search(r"(?mi)^ *(?:doc-uri|documentation) +(\S+)$", output_of("gst-inspect-1.0", "--no-colors", name))
                self.assertIsNotNone(link, "gst-inspect-1.0 prints a link")
                self.assertTrue(link[1].startswith(os.environ["WEIR_DOC_URL"]), link[1])
                self.assertTrue((SOURCE / link[1].removeprefix(os.environ["WEIR_DOC_URL"] + "/")).is_file(), link[1])

    def test_the_plugin_names_the_documents(self):
        for plugin in ("weir", "weiredge"):
            self.assertIn(f"{os.environ['WEIR_DOC_URL']}/README.md", output_of("gst-inspect-1.0", "--no-colors", plugin))

    def test_decoder_options_say_what_they_are(self):
        printed = output_of("gst-inspect-1.0", "--no-colors", "tensor_decoder")
        options = dict(re.findall(r"(?m)^  (option[1-9]) *: (.*)$", printed))
        self.assertEqual(len(options), 9)
        self.assertIn("image_labeling: label file", options["option1"])
        self.assertIn("bounding_boxes: size of the output, W:H", options["option4"])
        self.assertEqual(len(set(options.values())), 9)

    def test_what_is_no_element_does_not_exist(self):
        for name in ("tensor_nothing", "weir_converter", ""):
            with self.subTest(name):
                self.assertFalse(exists(name))


if __name__ == "__main__":
    tap_runner.main()
