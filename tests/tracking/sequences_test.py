#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests the generator of sequences: its files, what docs/tracking.md says about them, and what it refuses."""

import dataclasses
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy
import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
PROGRAM = SOURCE / "tools/tracking/sequences.py"
sys.path.insert(0, str(PROGRAM.parent))
import sequences  # noqa: E402


def small(name, frames=60):
    return dataclasses.replace(sequences.SCENES[name], frames=frames)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_program(self, *words):
        return subprocess.run([PROGRAM, self.folder, *words], capture_output=True, text=True, timeout=60)

    def test_the_same_seed_makes_the_same_files(self):
        one, two = (sequences.make(small("all"), 5) for _ in range(2))
        self.assertEqual(list(sequences.truth_lines(one)), list(sequences.truth_lines(two)))
        self.assertEqual(list(sequences.found_lines(one)), list(sequences.found_lines(two)))
        self.assertNotEqual(list(sequences.found_lines(one)), list(sequences.found_lines(sequences.make(small("all"), 6))))

    def test_the_files_of_a_sequence(self):
        done = self.run_program("--scenes", "all", "--seeds", "3,4", "--frames", "5", "--pictures", "--embeddings")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.split(), [f"{self.folder}/all-3", f"{self.folder}/all-4"])
        for name in ("all-3", "all-4"):
            folder = self.folder / name
            found = (folder / "det/det.txt").read_text().splitlines()
            vectors = numpy.load(folder / "det/embeddings.npy")
            self.assertEqual(vectors.shape, (len(found), 16))
            numpy.testing.assert_allclose(numpy.linalg.norm(vectors, axis=1), 1, atol=1e-5)
            self.assertEqual({line.split(",")[1] for line in found}, {"-1"})
            self.assertEqual(sorted(path.name for path in (folder / "img1").iterdir()), [f"{i:06}.png" for i in range(1, 6)])
            self.assertIn("seqLength=5\n", (folder / "seqinfo.ini").read_text())

    def test_the_pictures_show_the_truth(self):
        frame = sequences.make(small("crossings", 1), 1)[0]
        shown = sequences.picture(frame)
        self.assertEqual(shown.shape, (540, 960))
        nearest = numpy.argmax(frame.boxes[:, 3])
        x1, y1, x2, y2 = frame.boxes[nearest].astype(int)
        self.assertEqual(set(shown[y1:y2, x1:x2].ravel()), {40 + int(frame.numbers[nearest]) * 37 % 160})

    def test_what_it_refuses(self):
        for words, text in ((("--scenes", "rain"), "there is no scene rain\n  fix: --scenes crossings,"),
                            (("--seeds", "1,x"), "seeds are whole numbers\n  fix: --seeds 1,2,3"),
                            (("--frames", "0"), "at least one frame\n  fix: --frames 300")):
            done = self.run_program(*words)
            self.assertEqual(done.returncode, 1)
            self.assertIn(text, done.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])


class Scenes(unittest.TestCase):
    def test_the_truth_is_consistent(self):
        for name in sequences.SCENES:
            for frame in sequences.make(small(name), 1):
                self.assertEqual(len(set(frame.numbers)), len(frame.numbers))
                self.assertTrue((frame.boxes[:, 2:] > frame.boxes[:, :2]).all())
                self.assertTrue((frame.boxes >= 0).all() and (frame.boxes <= [960, 540, 960, 540]).all())
                self.assertTrue(((frame.visible >= 0) & (frame.visible <= 1)).all())

    def test_the_visible_part_is_the_area_that_nothing_covers(self):
        """A pillar over the left half of the second box; the first one is nearer and covers a quarter of the third."""
        boxes = numpy.array([[100, 100, 140, 200], [300, 90, 340, 190], [120, 50, 160, 150]], float)
        visible = sequences.visible_parts(boxes, numpy.array([[280, 0, 320, 540]], float))
        numpy.testing.assert_allclose(visible, [1, 0.5, 0.75])

    def test_as_many_boxes_as_the_scene_says(self):
        """400 frames with no occlusion, far apart: the number found is binomial, that of false alarms Poisson; five sigma."""
        scene = sequences.Scene(frames=400, objects=1, found=0.7, false_alarms=2, jitter=0.05, speed=1)
        frames = sequences.make(scene, 2)
        errors, right, false = [], 0, 0
        for frame in frames:
            size = frame.boxes[0, 2:] - frame.boxes[0, :2]
            off = ((frame.found[:, :2] + frame.found[:, 2:4]) - (frame.boxes[0, :2] + frame.boxes[0, 2:])) / 2 / size
            is_near = (numpy.abs(off) < 0.3).all(1) & (frame.found[:, 4] > 0.7)
            errors += list(off[is_near])
            right += is_near.sum()
            false += (~is_near).sum()
        self.assertLess(abs(right - 280), 5 * (400 * 0.7 * 0.3) ** 0.5 + 5)
        self.assertLess(abs(false - 800), 5 * 800 ** 0.5 + 5)
        self.assertAlmostEqual(numpy.std(errors), 0.05, delta=0.01)

    def test_the_camera_shifts_all_that_is_in_a_frame(self):
        """The boxes of still objects move by the same distance."""
        scene = sequences.Scene(frames=30, shake=20, speed=0, sway=0, found=1, jitter=0)
        frames = sequences.make(scene, 3)
        moves = numpy.array([b.boxes[:, 3] - a.boxes[:, 3] for a, b in zip(frames, frames[1:]) if list(a.numbers) == list(b.numbers)])
        self.assertGreater(numpy.abs(moves).max(), 1)
        self.assertLess(moves.std(axis=1).max(), 0.3)  # the slow walk downwards is different for each


if __name__ == "__main__":
    tap_runner.main()
