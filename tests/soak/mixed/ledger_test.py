#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The ledger of the soak test: what it counts as lost, and what it finds wrong."""

import json
import os
import pathlib
import tempfile
import unittest

import ledger
import streams
import tap_runner

SECOND = 1_000_000_000


def frames(*numbers):
    """One frame a second."""
    return [(number, when * SECOND) for when, number in enumerate(numbers)]


class Missing(unittest.TestCase):
    def test_a_gap_is_missing(self):
        self.assertEqual(ledger.missing_frames(6, frames(0, 1, 4, 5), []), (2, 0, 0))

    def test_frames_that_never_arrive_are_missing(self):
        self.assertEqual(ledger.missing_frames(6, frames(0, 1, 2), []), (3, 0, 0))

    def test_a_gap_around_a_kill_belongs_to_it(self):
        self.assertEqual(ledger.missing_frames(6, frames(0, 1, 4, 5), [1.5 * SECOND]), (0, 2, 0))
        self.assertEqual(ledger.missing_frames(6, frames(0, 1, 4, 5), [30 * SECOND]), (2, 0, 0))

    def test_frames_that_come_again_are_repeated(self):
        self.assertEqual(ledger.missing_frames(4, frames(0, 1, 2, 1, 2, 3), []), (0, 0, 2))


class Account(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def account(self, got, dropped, held=0, **options):
        for name, written in (("sent", frames(*range(10))), ("got", got)):
            pathlib.Path(f"one.end.{name}").write_bytes(b"".join(ledger.RECORD.pack(*one) for one in written))
        counters = {"received": 10, "consumed": 10 - dropped, "dropped": dropped, "held": held}
        pathlib.Path("one.end.stats").write_text(json.dumps({"pid": 1, "run": 1, "final": True, "stats": {"net": counters}}) + "\n")
        return ledger.account("one", streams.Stream({}, counted=[("net", "dropped")], **options), [])["wrong"]

    def test_counted_frames_may_be_missing(self):
        self.assertEqual(self.account(frames(0, 1, 2, 3, 6, 7, 8, 9), 2), "")

    def test_frames_that_are_not_counted_may_not_be_missing(self):
        self.assertIn("2 frames are missing", self.account(frames(0, 1, 2, 3, 6, 7, 8, 9), 1))

    def test_an_exact_stream_counts_no_frame_that_arrived(self):
        self.assertIn("the elements counted 1", self.account(frames(*range(10)), 1, exact=True))

    def test_an_element_must_add_up(self):
        self.assertIn("net:", self.account(frames(*range(10)), 0, held=1))

    def test_only_some_streams_may_repeat_frames(self):
        got = frames(*range(10), 8, 9)
        self.assertIn("2 frames arrived twice", self.account(got, 0))
        self.assertEqual(self.account(got, 0, repeats=True), "")


class Growth(unittest.TestCase):
    def rows(self, **columns):
        row = {"process": "one", "pid": 1, "anon_kb": 1000, "allocated_kb": 500, "descriptors": 9, "threads": 4}
        return [{**row, "seconds": seconds, **{name: row[name] + change(seconds) for name, change in columns.items()}}
                for seconds in range(0, 3601, 10)]

    def compare(self, **columns):
        return ledger.compare(self.rows(**columns), (300, 360), (3540, 3600))

    def test_what_stays_is_right(self):
        self.assertEqual(self.compare(anon_kb=lambda seconds: seconds % 100), [])

    def test_memory_that_grows_is_found(self):
        self.assertEqual(self.compare(anon_kb=lambda seconds: 2 * seconds), ["one: anon_kb grows by 7200 KB an hour, at most 4096 may be"])

    def test_descriptors_that_remain_are_found(self):
        self.assertEqual(self.compare(descriptors=lambda seconds: seconds > 2000), ["one: 10 descriptors at the end, 9 after warming up"])


if __name__ == "__main__":
    tap_runner.main()
