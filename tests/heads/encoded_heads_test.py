#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads outputs that independent encoders make of known objects, for each head, in a pipeline with tensor_decoder.

The encoders are written from the published descriptions of the networks. A network that always gives these outputs stands
between tensor_preprocess, which makes a letterbox, and tensor_decoder: results must be the objects of the source picture.
"""

import dataclasses
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import recording
import tap_runner
from examples import HEADS
from refusal import refusal

# Each of hundreds of branches takes 0.1 s with the tracer of leaks, which other tests play these elements with.
WITHOUT_TRACERS = {key: value for key, value in os.environ.items() if key not in ("GST_TRACERS", "GST_DEBUG")}


def unpacked(mask):
    """The pixels of a mask of the JSON: COCO's compressed run-length code, down the columns (docs/results.md)."""
    text, runs, at = mask["counts"], [], 0
    while at < len(text):
        value, bits, more = 0, 0, True
        while more:
            group = ord(text[at]) - 48
            value |= (group & 31) << bits
            at, bits, more = at + 1, bits + 5, group & 32
        if group & 16:
            value -= 1 << bits
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
    height, width = mask["size"]
    pixels = numpy.repeat(numpy.arange(len(runs)) % 2, runs)
    return pixels.reshape(width, height).T.astype(bool)


class Heads(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def network(self, example, kind, name):
        """A pipeline up to the outputs of the network."""
        model = recording.write(self.folder / f"{name}.recorded", example.view.input, example.outputs, kind, example.metadata)
        (width, height), (of_width, of_height) = example.view.source, example.view.input
        return (f"videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width={width},height={height} ! "
                f"tensor_preprocess width={of_width} height={of_height} fit=letterbox type=uint8 ! "
                f"tensor_filter framework=recorded model={model}")

    def branch(self, head, mode, example, kind, name):
        """A whole pipeline; `head`: None where it is to be recognised."""
        custom = ",".join(filter(None, [head and f"head:{head}", example.custom]))
        decoder = f"tensor_decoder mode={mode} {example.properties}" + (f" custom={custom}" if custom else "")
        if example.labels:
            labels = self.folder / f"{name}.txt"
            labels.write_text("".join(label + "\n" for label in example.labels))
            decoder += f" labels={labels}"
        text = "" if mode == "depth" else " ! tensor_decoder mode=json custom=masks:rle"
        return f"{self.network(example, kind, name)} ! {decoder}{text} ! filesink location={self.folder / name}.out"

    def play(self, head, mode, entry, is_named=True):
        """All orders and element types of a head in one process. Gives order, type, example and results of each."""
        left_out = () if is_named else entry.unnamed + entry.likelier
        cases = [(order, kind, entry.encode(order, kind)) for order in entry.orders if order not in left_out for kind in entry.kinds]
        line = "  ".join(self.branch(head if is_named else None, mode, example, kind, f"case{number}")
                         for number, (_, kind, example) in enumerate(cases))
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=200,
                              stdin=subprocess.DEVNULL, env=WITHOUT_TRACERS)
        self.assertEqual(done.returncode, 0, done.stderr[-3000:])
        self.assertNotRegex(done.stderr, "CRITICAL|WARNING|ERROR")
        for number, (order, kind, example) in enumerate(cases):
            yield order, kind, example, (self.folder / f"case{number}.out").read_bytes()

    def check(self, mode, kind, example, results):
        if mode == "depth":
            depths = numpy.frombuffer(results[-4 * example.map.size:], "f4")  # after the table of rows
            step = numpy.ptp(example.map) * {"float32": 1e-6, "float16": 1e-3}.get(kind, 0.004)
            numpy.testing.assert_allclose(depths.reshape(example.map.shape), example.map, rtol=0, atol=step)
            return
        lines = results.decode().splitlines()
        self.assertEqual(len(lines), 1)
        frame = json.loads(lines[0])
        self.assertEqual(frame["size"], list(example.view.source))
        if mode == "classification":
            self.classes(kind, example, frame["labels"])
        elif example.text:
            self.assertEqual([entry["text"] for entry in frame["text"]], [example.text])
            self.assertAlmostEqual(frame["text"][0]["score"], 0.95, delta=0.01)
        elif "segments" in frame:
            self.segments(example, frame["segments"])
        else:
            self.objects(mode, kind, example, frame["detections"])

    def classes(self, kind, example, found):
        self.assertEqual([entry["index"] for entry in found], [thing.index for thing in example.things])
        for entry, thing in zip(found, example.things):
            self.assertAlmostEqual(entry["score"], thing.score, delta=example.scores[kind])

    def same(self, example, mask, is_inside):
        """Pixels of the source picture: an edge is as exact as a cell of the map."""
        width, height = example.view.source
        self.assertEqual(mask["size"], [height, width])
        wanted = is_inside(*numpy.meshgrid(numpy.arange(width) + 0.5, numpy.arange(height) + 0.5))
        pixels = unpacked(mask)
        self.assertGreater((pixels & wanted).sum() / (pixels | wanted).sum(), 0.93)

    def segments(self, example, found):
        by_class = {segment["index"]: segment["mask"] for segment in found}
        self.assertLessEqual({thing.index for thing in example.things}, set(by_class))
        self.assertLessEqual(set(by_class), {0, *(thing.index for thing in example.things)})
        for thing, is_inside in zip(example.things, example.masks):
            self.same(example, by_class[thing.index], is_inside)

    def objects(self, mode, kind, example, found):
        pixels, scores = example.pixels[kind], example.scores[kind]
        self.assertEqual(len(found), len(example.things), found)
        for number, thing in enumerate(example.things):
            near = [entry for entry in found if abs(numpy.array(entry["box"]) - thing.box).max() <= pixels]
            self.assertEqual(len(near), 1, f"{thing}, {pixels} pixels, in {found}")
            self.assertEqual(near[0].get("index", 0), thing.index)
            self.assertAlmostEqual(near[0]["score"], thing.score, delta=scores)
            turn = near[0].get("rotation", 0) - thing.rotation
            self.assertAlmostEqual((turn + numpy.pi) % (2 * numpy.pi) - numpy.pi, 0, delta=0.1 if pixels > 1 else 0.02)
            if thing.points is not None:
                self.points(near[0]["keypoints"], thing, pixels, scores)
            if example.masks:
                self.same(example, near[0]["mask"], example.masks[number])

    def points(self, found, thing, pixels, scores):
        found = numpy.array(found)
        self.assertEqual(found.shape, thing.points.shape)
        self.assertLessEqual(abs(found[:, :2] - thing.points[:, :2]).max(), pixels)
        self.assertLessEqual(abs(found[:, 2] - thing.points[:, 2]).max(), scores)

    def test_known_objects_are_found_by_a_head_that_is_named(self):
        for head, entry in HEADS.items():
            for mode in entry.modes:
                with self.subTest(head=head, mode=mode):
                    for order, kind, example, results in self.play(head, mode, entry):
                        with self.subTest(head=head, mode=mode, order=order, kind=kind):
                            self.check(mode, kind, example, results)

    def test_known_objects_are_found_by_a_head_that_is_recognised(self):
        recognised = 0
        for head, entry in HEADS.items():
            if set(entry.orders) == {*entry.unnamed, *entry.likelier}:
                continue
            recognised += 1
            with self.subTest(head=head):
                for order, kind, example, results in self.play(head, entry.modes[-1], entry, False):
                    with self.subTest(head=head, order=order, kind=kind):
                        self.check(entry.modes[-1], kind, example, results)
        self.assertGreaterEqual(recognised, 31)

    def test_heads_that_share_their_outputs_with_others_are_named_by_the_error(self):
        for head, entry in HEADS.items():
            for order in entry.unnamed:
                with self.subTest(head=head, order=order):
                    example = entry.encode(order, "float32")
                    text = refusal(self, self.branch(None, entry.modes[-1], example, "float32", "unnamed"))
                    self.assertIn("the outputs fit several heads: ", text)
                    self.assertIn(f"custom=head:{head}", text)

    def test_another_head_of_the_same_outputs_finds_other_objects(self):
        """Shows that the comparison tells heads apart."""
        for head, other in (("yolov3-grids", "yolov5-grids"), ("yolov5-grids", "yolov7-grids"), ("detr", "rtdetr"), ("rtdetr", "detr"),
                            ("ultraface-raw", "ultraface"), ("yolov7-end2end", "detection-output"), ("yolov8", "yolox"),
                            ("yolov8-obb", "yolov8"), ("nanodet", "yolov8")):
            with self.subTest(head=head, other=other):
                entry = dataclasses.replace(HEADS[head], orders=HEADS[head].orders[:1], kinds=("float32",))
                (_, kind, example, results), = self.play(other, "detection", entry)
                with self.assertRaises(AssertionError):
                    self.check("detection", kind, example, results)

    def test_every_head_has_an_encoder(self):
        names = subprocess.run([os.environ["WEIR_DECODE_MODEL"], "--heads"], capture_output=True, text=True, check=True).stdout
        self.assertEqual({line.split("|")[0] for line in names.splitlines()}, set(HEADS))


if __name__ == "__main__":
    tap_runner.main()
