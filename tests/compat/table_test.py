#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests the table of NNStreamer's elements: its rows, and that the committed table matches the plug-in."""

import os
import pathlib
import subprocess
import sys
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
sys.path.insert(0, str(SOURCE / "tools"))
import compat_table  # noqa: E402

UINT = ("Unsigned Integer. Range: 1 - 9 Default: 3", "readable, writable")
FACT = ("guint", "RW", "3", "1..9")


class Table(unittest.TestCase):
    def test_it_matches_the_plugin(self):
        done = subprocess.run([SOURCE / "tools" / "gen-docs", "--check", "--build", os.environ["WEIR_BUILD"]],
                              capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)

    def test_every_element_and_property_of_the_facts_is_in_it(self):
        page = compat_table.PAGE.read_text(encoding="utf-8")
        facts = compat_table.nnstreamer()
        self.assertEqual(len(facts), 32)
        self.assertEqual(sum(len(properties) for _, properties in facts.values()), 214)
        for name, (_, properties) in facts.items():
            section = page.split(f"\n## {name}\n")[1].split("\n## ")[0]
            for prop in properties:
                self.assertIn(f"`{prop}`", section, name)

    def test_what_is_the_same_has_no_difference(self):
        self.assertEqual(compat_table.differences(FACT, UINT), [])
        self.assertEqual(compat_table.differences(("gchararray", "RW", "NULL", ""), ('String. Default: ""', "writable")), [])
        self.assertEqual(compat_table.differences(("gboolean", "R", "TRUE", ""), ("Boolean. Default: true", "readable")), [])
        self.assertEqual(compat_table.differences(
            ("mode", "RW", "1", "0=OFF / off, 1=ON (default)"),
            ('Enum "M" Default: 1, "ON"; (0): OFF - No; (1): ON - Yes', "writable")), [])

    def test_each_difference_is_reported(self):
        for own, output in {("Integer. Range: 1 - 9 Default: 3", "writable"): "type is Integer",
                          ("Unsigned Integer. Range: 1 - 8 Default: 3", "writable"): "the range is 1 to 8, not 1 to 9",
                          ("Unsigned Integer. Range: 1 - 9 Default: 4", "writable"): "the default is 4, not 3",
                          (UINT[0], "readable"): "read-only"}.items():
            self.assertEqual(compat_table.differences(FACT, own), [output])
        self.assertEqual(compat_table.differences(("mode", "RW", "0", "0=OFF, 1=ON"),
                                                  ('Enum "M" Default: 0, "OFF"; (0): OFF - No', "writable")), ["lacks ON"])

    def test_what_is_not_there_is_reported(self):
        facts = ("nnstreamer", {"one": FACT, "two": FACT})
        rows = "\n".join(compat_table.element_section("x", facts, f"| `one` | {UINT[0]} | {UINT[1]} | of it |\n"))
        self.assertIn("| `one` | same |  |\n| `two` | **missing** |  |", rows)
        self.assertIn("**Not implemented yet**", "\n".join(compat_table.element_section("x", facts, None)))


if __name__ == "__main__":
    tap_runner.main()
