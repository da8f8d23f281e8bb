#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests the independent metrics of tracks, and the plain tracker, on cases whose results can be computed by hand."""

import itertools
import unittest

import metrics
import numpy
import plain_iou
import tap_runner

BOX, OTHER, FAR = [0, 0, 10, 20], [50, 0, 60, 20], [500, 0, 510, 20]


class Metrics(unittest.TestCase):
    def check(self, sequence, mota, idf1, hota, switches):
        found = metrics.scores([sequence])
        for name, value in (("MOTA", mota), ("IDF1", idf1), ("HOTA", hota)):
            self.assertAlmostEqual(found[name], value, places=12, msg=name)
        self.assertEqual(found["switches"], switches)

    def test_all_is_right(self):
        self.check([({1: BOX, 2: OTHER}, {7: BOX, 8: OTHER})] * 5, 1, 1, 1, 0)

    def test_nothing_is_found(self):
        self.check([({1: BOX}, {})] * 5, 0, 0, 0, 0)

    def test_a_false_box_in_each_frame(self):
        """MOTA 1 - 5/5; IDF1 10/15; HOTA: detection 5/10, association 1."""
        self.check([({1: BOX}, {7: BOX, 8: FAR})] * 5, 0, 10 / 15, 0.5 ** 0.5, 0)

    def test_two_tracks_exchange_their_numbers(self):
        """After half of 10 frames: 2 switches of 20 boxes; half of the boxes have the right track; association 5/(5+5+5) for each match."""
        before, after = ({1: BOX, 2: OTHER}, {7: BOX, 8: OTHER}), ({1: BOX, 2: OTHER}, {8: BOX, 7: OTHER})
        self.check([before] * 5 + [after] * 5, 0.9, 0.5, (1 / 3) ** 0.5, 2)

    def test_a_track_breaks(self):
        """1 switch of 10 boxes; 5 of 10 in the longest; association 5/10."""
        self.check([({1: BOX}, {7: BOX})] * 5 + [({1: BOX}, {8: BOX})] * 5, 0.9, 0.5, 0.5 ** 0.5, 1)

    def test_half_of_the_overlap(self):
        """An overlap of 0.6 is a match for the thresholds up to 0.6, which are 12 of 19."""
        self.check([({1: [0, 0, 10, 10]}, {7: [0, 0, 10, 6]})], 1, 1, 12 / 19, 0)

    def test_a_match_is_kept_though_another_box_fits_better(self):
        sequence = [({1: [0, 0, 10, 10]}, {7: [0, 0, 10, 10]}), ({1: [0, 0, 10, 10]}, {7: [0, 0, 10, 6], 8: [0, 0, 10, 10]})]
        self.assertEqual(list(metrics.clear_mot(sequence)), [0, 1, 0, 2])  # no switch to 8, which is false


class Assignments(unittest.TestCase):
    def test_are_as_good_as_the_best_of_all(self):
        random = numpy.random.default_rng(1)
        for rows, columns in itertools.product(range(1, 6), repeat=2):
            values = random.integers(0, 9, (rows, columns)) * (random.random((rows, columns)) < 0.6)
            small, wide = (values, values.shape[1]) if rows <= columns else (values.T, values.shape[0])
            best = max(sum(small[r, c] for r, c in enumerate(order)) for order in itertools.permutations(range(wide), len(small)))
            for method in (metrics.best_pairs, metrics.most_common):
                pairs = method(values.astype(float))
                self.assertEqual(sum(values[pair] for pair in pairs), best)
                self.assertEqual(len({r for r, _ in pairs}), len(pairs))
                self.assertEqual(len({c for _, c in pairs}), len(pairs))


class PlainTracker(unittest.TestCase):
    def rows(self, *boxes):
        return numpy.array([[*box, 0.9] for box in boxes]).reshape(-1, 5)

    def test_follows_what_overlaps(self):
        found = plain_iou.follow([self.rows([x, 0, x + 40, 80]) for x in range(0, 50, 5)])
        self.assertEqual([list(frame) for frame in found], [[]] + [[1]] * 9)

    def test_loses_what_moves_during_a_gap(self):
        found = plain_iou.follow([self.rows(*([] if 5 <= i < 12 else [[9 * i, 0, 9 * i + 40, 80]])) for i in range(20)])
        self.assertEqual([list(frame) for frame in found], [[], [1], [1], [1], [1]] + [[]] * 8 + [[2]] * 7)

    def test_low_scores_are_no_boxes(self):
        self.assertEqual(plain_iou.follow([numpy.array([[0, 0, 9, 9, 0.4]])] * 3), [{}] * 3)


if __name__ == "__main__":
    tap_runner.main()
