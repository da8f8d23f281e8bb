#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares pose_estimation, image_segment and tensor_region in whole pipelines with NumPy, byte for byte."""

import struct
import unittest

import numpy as np

import picture_decoders_reference as reference
import tap_runner
from decoder_case import DecoderCase
from drawing_reference import WHITE, Glyphs

FRAMES = 4
# A connection with itself is a dot; the longest name has 15 bytes; bytes beyond ASCII are drawn as stars.
PEOPLE = [("Kopf", [1, 2]), ("links", [0, 2, 1]), ("rechts~", []), ("Füße", [3, 0]), ("fifteen_letters", [3, 4])]


def header(dims, kind, fmt):
    """The 128 bytes in front of a flexible tensor (docs/compatibility/types-and-caps.md 1.7)."""
    return struct.pack("<21I", 0xfeedcced, 0xDE001000, kind, *dims, *[0] * (16 - len(dims)), fmt, 4).ljust(128, b"\0")


class Poses(DecoderCase):
    OUTPUT, SIZE = (320, 240), (257, 193)

    def compare(self, tensors, options, size, body):
        drawn = self.pictures(tensors, f"mode=pose_estimation option1={self.OUTPUT[0]}:{self.OUTPUT[1]} "
                              f"option2={size[0]}:{size[1]} {options}", self.OUTPUT)
        glyphs, found = Glyphs(WHITE), 0
        for i in range(FRAMES):
            places = reference.joints(tensors[0][i], self.OUTPUT, size, *(t[i] for t in tensors[1:]))
            found += sum(place is not None for place in places)
            glyphs.compare(drawn[i], reference.draw_pose(places, self.OUTPUT, body))
        self.assertGreater(found, FRAMES)
        self.assertLess(found, FRAMES * len(body), "some are not found")
        return glyphs

    def body(self, body):
        lines = [" ".join([name, *map(str, connected)]) for name, connected in body]
        return f"option3={self.file('body.txt', chr(10).join(lines) + chr(10))}"

    def heat(self, points, most):
        """Maps of which most have a peak above one half."""
        heat = self.random.uniform(0, 0.5, (FRAMES, 25, 33, points)).astype("f4")
        for i in range(FRAMES):
            for k in range(points):
                heat[i, self.random.integers(25), self.random.integers(33), k] = self.random.uniform(0.4, most)
        return heat

    def test_heat_maps_of_the_default_body(self):
        # option2 is the size of the grid here.
        self.compare([self.heat(14, 1)], "", (33, 25), reference.BODY).check(5)
        self.compare([self.heat(14, 1)], "option4=heatmap-only", (33, 25), reference.BODY)

    def test_heat_maps_of_a_body_from_a_file(self):
        self.compare([self.heat(len(PEOPLE), 0.7)], self.body(PEOPLE), (33, 25), PEOPLE)

    def test_a_grid_that_is_larger_than_option2_ends_at_the_edge(self):
        self.compare([self.heat(14, 1)], "", (20, 20), reference.BODY)

    def test_offsets(self):
        logits = (self.heat(14, 1) - 0.5) * 12
        offsets = self.random.normal(0, 12, (FRAMES, 25, 33, 28)).astype("f4")
        self.compare([logits.astype("f4"), offsets], "option4=heatmap-offset", self.SIZE, reference.BODY).check(5)

    def test_offsets_of_a_body_from_a_file(self):
        points = len(PEOPLE)
        logits = (self.heat(points, 0.8) - 0.5) * 12
        offsets = self.random.normal(0, 200, (FRAMES, 25, 33, 2 * points)).astype("f4")
        self.compare([logits.astype("f4"), offsets], f"option4=heatmap-offset {self.body(PEOPLE)}", self.SIZE, PEOPLE)


class Segments(DecoderCase):
    SIZE = (61, 47)

    def compare(self, tensor, options, wanted):
        pixels = self.pictures([tensor], f"mode=image_segment {options}", self.SIZE).view("<u4")[:, :, :, 0]
        for i in range(FRAMES):
            np.testing.assert_array_equal(pixels[i], wanted(tensor[i]))

    def scores(self, labels):
        return self.random.uniform(0, 0.5 + 0.6 / labels, (FRAMES, *self.SIZE[::-1], labels + 1)).astype("f4")

    def test_scores(self):
        for labels in (1, 2, 20, 300):
            with self.subTest(labels=labels):
                option = "" if labels == 20 else f"option2={labels}"
                self.compare(self.scores(labels), f"option1=tflite-deeplab {option}",
                             lambda scores: reference.segment_scores(scores, labels))

    def test_a_score_of_one_half_is_background(self):
        scores = np.zeros((FRAMES, *self.SIZE[::-1], 21), "f4")
        scores[:, ::2, :, 5], scores[:, :, ::2, 7] = 0.5, np.nextafter(np.float32(0.5), np.float32(1))
        self.compare(scores, "option1=tflite-deeplab", lambda s: reference.segment_scores(s, 20))

    def test_numbers(self):
        for labels in (1, 20, 1000):
            with self.subTest(labels=labels):
                numbers = self.random.integers(0, labels + 1, (FRAMES, *self.SIZE[::-1])).astype("f4")
                self.compare(numbers, f"option2={labels} option1=snpe-deeplab", lambda n: reference.segment_numbers(n, labels))

    def test_depths(self):
        depths = self.random.gamma(2, 3, (FRAMES, *self.SIZE[::-1], 1)).astype("f4")
        depths[1] = 0
        depths[2, :, :30] = 0
        self.compare(depths, "option1=snpe-depth", lambda d: reference.depths(d[:, :, 0]))


class Regions(DecoderCase):
    SIZE, ANCHORS, CLASSES = (90, 70), 120, 4

    def heads(self):
        boxes = self.random.normal(0, 1, (FRAMES, self.ANCHORS, 1, 4)).astype("f4")
        return [boxes, self.random.normal(-4, 2, (FRAMES, self.ANCHORS, self.CLASSES)).astype("f4")]

    def decoder(self, count, priors, parameters=""):
        names = self.labels([f"class {i}" for i in range(self.CLASSES)])
        return (f"mode=tensor_region option3={priors}{parameters} option1={count} {names} "
                f"option4={self.SIZE[0]}:{self.SIZE[1]}")

    def test_regions_are_those_of_the_best_boxes(self):
        heads, (priors, path) = self.heads(), self.priors(self.ANCHORS)
        for count, text, values in ((1, "", ()), (7, ":0.3", (0.3,)), (200, ":0.2:8:9::4:0.2", (0.2, (8, 9, 5, 4), 0.2))):
            with self.subTest(count=count):
                wanted = [reference.regions(b, s, priors, self.SIZE, count, *values) for b, s in zip(*heads)]
                self.assertTrue(any(w.any() for w in wanted))
                # A uint32 tensor; its header says static, as NNStreamer's does.
                self.assertEqual(self.decoded(heads, self.decoder(count, path, text)),
                                 b"".join(header([4, count], 1, 0) + w.tobytes() for w in wanted))

    def test_regions_are_cut_out_by_tensor_crop(self):
        heads, (priors, path) = self.heads(), self.priors(self.ANCHORS)
        width, height = self.SIZE
        raw = self.random.integers(0, 256, (FRAMES, height, width, 3)).astype("u1")
        self.launch(f"{self.source([raw], 'raw')} ! crop.raw  {self.source(heads)} ! "
                    f"tensor_decoder {self.decoder(9, path, ':0.3')} ! crop.info  tensor_crop name=crop ! "
                    f"filesink location={self.folder / 'out'}")
        wanted, cut = b"", 0
        for frame, boxes, scores in zip(raw, *heads):
            for x, y, w, h in reference.regions(boxes, scores, priors, self.SIZE, 9, 0.3):
                part = frame[y:y + h, x:x + w]
                if part.size:
                    wanted += header([3, part.shape[1], part.shape[0], 1], 5, 1) + part.tobytes()
                    cut += 1
        self.assertGreater(cut, 2 * FRAMES)
        self.assertEqual((self.folder / "out").read_bytes(), wanted)


if __name__ == "__main__":
    tap_runner.main()
