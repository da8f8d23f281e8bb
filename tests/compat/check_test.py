#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir check` with objects built for NNStreamer: it lists their properties, and faulty files do no harm."""

import os
import subprocess
import unittest

import tap_runner


def sections():
    """Maps each section to its names and the lines below them."""
    done = subprocess.run([os.environ["WEIR_COMMAND"], "check"], capture_output=True, text=True, timeout=60, check=False)
    if done.returncode:
        raise AssertionError(done.stdout + done.stderr)
    found = {}
    for line in done.stdout.split("registered sub-plugins:\n")[1].splitlines()[1:]:
        if line.startswith("["):
            section = found.setdefault(line.strip("[]"), {})
        elif line.startswith("    "):
            lines.append(line.strip())
        else:
            lines = section.setdefault(line.strip(), [])
    return found


class SubPlugins(unittest.TestCase):
    def test_each_is_listed_with_its_properties(self):
        found = sections()
        self.assertEqual(list(found), ["Filter", "Decoder", "Conterver", "Trainer"])
        self.assertIn("- option2: added to each byte", found["Decoder"]["adding"])
        self.assertEqual(found["Conterver"]["bytes"], ["- No custom property found"])
        self.assertIn("custom-easy", found["Filter"])

    def test_files_that_cannot_be_used_have_no_properties(self):
        found = sections()
        for name in ("halved", "silent", "nameless"):
            self.assertEqual(found["Decoder"][name], ["- No custom property found"], name)


if __name__ == "__main__":
    tap_runner.main()
