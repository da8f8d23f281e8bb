# SPDX-License-Identifier: LGPL-2.1-or-later
"""Helpers for comparing real models with the reference results of ../shared: pictures as arrays, models in pipelines."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
MODELS, MEDIA = SHARED / "models", SHARED / "media"
# MANIFEST.md allows 10 px. Networks of float32 are closer; those of 8 bits have steps of several
# pixels and hundredths.
PIXELS, EXACT, SCORE = 10, 2, 0.05
LEAKED = r"object-alive, type-name=\(string\)\w+|CRITICAL|WARNING|ERROR"


def results(name="reference_results"):
    return json.loads((MEDIA / f"{name}.json").read_text())


def stretched(picture, width, height):
    """Bilinear interpolation with aligned pixel centres, as the references were scaled."""
    def places(new, old):
        at = ((numpy.arange(new) + 0.5) * old / new - 0.5).clip(0, old - 1)
        low = at.astype(int).clip(0, max(old - 2, 0))
        return low, numpy.minimum(low + 1, old - 1), at - low
    top, bottom, down = places(height, picture.shape[0])
    left, right, over = places(width, picture.shape[1])
    down, over = down[:, None, None], over[None, :, None]
    wide = picture[:, left] * (1 - over) + picture[:, right] * over
    return (wide[top] * (1 - down) + wide[bottom] * down).round().astype("u1")


def size_of(path):
    """Height and width from the file's header: a PNG's, or a JPEG's frame."""
    data = path.read_bytes()
    if data.startswith(b"\x89PNG"):
        return int.from_bytes(data[20:24], "big"), int.from_bytes(data[16:20], "big")
    at = 2
    while data[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + int.from_bytes(data[at + 2:at + 4], "big")
    return int.from_bytes(data[at + 5:at + 7], "big"), int.from_bytes(data[at + 7:at + 9], "big")


def planes(picture):
    return picture.transpose(2, 0, 1)[None].astype("f4")


def sigmoid(x):
    return 1 / (1 + numpy.exp(-x))


def overlap(box, boxes):
    """Intersection over union of x1, y1, x2, y2."""
    sides = numpy.minimum(box[2:], boxes[:, 2:]) - numpy.maximum(box[:2], boxes[:, :2])
    both = sides.clip(0).prod(axis=1)
    return both / ((box[2:] - box[:2]).prod() + (boxes[:, 2:] - boxes[:, :2]).prod(axis=1) - both)


def from_centres(centres, sizes):
    return numpy.concatenate([centres - sizes / 2, centres + sizes / 2], axis=1)


class PipelineCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def play(self, line):
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        self.assertNotRegex(done.stderr, LEAKED)
        self.assertNotRegex(done.stderr, "(?m)^INFO: ", "an engine's own log")


class ReferenceCase(PipelineCase):
    def setUp(self):
        if not MODELS.is_dir():
            self.skipTest(f"{MODELS} is not there")
        super().setUp()

    def picture(self, name, form="RGB"):
        """An array of rows, columns, colours."""
        result = self.folder / "picture.raw"
        self.play(f"filesrc location={MEDIA / name} ! gdkpixbufdec ! videoconvert ! video/x-raw,format={form} ! "
                  f"tensor_converter ! "
                  f"filesink location={result}")
        return numpy.fromfile(result, "u1").reshape(*size_of(MEDIA / name), -1)

    def first_frame(self, name, size):
        result = self.folder / "frame.raw"
        self.play(f"filesrc location={MEDIA / name} ! decodebin ! videoconvert ! video/x-raw,format=RGB ! tensor_converter ! "
                  f"tensor_aggregator frames-out=120 frames-dim=3 ! filesink location={result}")
        return numpy.fromfile(result, "u1", count=size[0] * size[1] * 3).reshape(*size, 3)

    def run_model(self, model, inputs, outputs, frames=1):
        """Runs arrays through tensor_filter; returns one array per output (shape, type) with all frames."""
        model = MODELS / model
        engine = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite"}[model.suffix]
        if not has_engine(engine):
            self.skipTest(f"the engine {engine} is not built")
        sources = []
        for number, array in enumerate(inputs):
            path, of_frame = self.folder / f"in{number}.raw", array if frames == 1 else array[0]
            numpy.ascontiguousarray(array).tofile(path)
            dimensions = ":".join(str(extent) for extent in reversed(of_frame.shape))
            sources.append(f"filesrc location={path} blocksize={of_frame.nbytes} ! application/octet-stream ! "
                           f"tensor_converter input-dim={dimensions} input-type={array.dtype.name}")
        result = self.folder / "out.raw"
        run = f"tensor_filter framework={engine} model={model} ! filesink location={result}"
        if len(sources) == 1:
            self.play(f"{sources[0]} ! {run}")
        else:
            self.play(f"tensor_mux name=m ! {run}  " + "  ".join(f"{s} ! m.sink_{n}" for n, s in enumerate(sources)))
        kinds = numpy.dtype([(f"o{n}", kind, shape) for n, (shape, kind) in enumerate(outputs)])
        values = numpy.fromfile(result, kinds)
        self.assertEqual(values.size, frames)
        found = [values[name] if frames > 1 else values[name][0] for name in kinds.names]
        return found[0] if len(found) == 1 else found


class DetectionCase(ReferenceCase):
    def agree(self, names, scores, boxes, reference, sure, pixels=PIXELS):
        """Each reference entry is among ours, and each of ours that scores above `sure` matches one of its entries."""
        for name, score, box in reference:
            near = (names == name) & (abs(scores - score) < SCORE) & (abs(boxes - numpy.array(box)).max(axis=1) < pixels)
            self.assertTrue(near.any(), f"{name} {score} {box}")
        known = numpy.array([box for _, _, box in reference])
        for name, box in zip(names[scores > sure], boxes[scores > sure]):
            on = overlap(box, known) > 0.5
            self.assertIn(name, [entry[0] for entry, there in zip(reference, on) if there], f"{name} at {box}")
