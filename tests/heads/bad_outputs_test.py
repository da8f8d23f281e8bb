#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What tensor_decoder makes of outputs, labels and model cards that are wrong: whole pipelines, as users run them."""

import hashlib
import json
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

import numpy

import onnx_writer
import recording
import tap_runner
import yolo
from built_modules import has_engine
from examples import HEADS
from refusal import refusal

WITHOUT_TRACERS = {key: value for key, value in os.environ.items() if key not in ("GST_TRACERS", "GST_DEBUG")}
SOURCE = "videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=640,height=480"
PREPARED = f"{SOURCE} ! tensor_preprocess width=320 height=320 fit=letterbox type=uint8"


def number(text):
    raise ValueError(f"{text} is no number of JSON")


class BadCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def line(self, outputs, decoder, metadata=None):
        model = recording.write(self.folder / "bad.recorded", (320, 320), outputs, metadata=metadata)
        return (f"{PREPARED} ! tensor_filter framework=recorded model={model} ! tensor_decoder {decoder} ! "
                f"tensor_decoder mode=json ! filesink location={self.folder}/out.jsonl")

    def play(self, line, path=None):
        done = subprocess.run(["gst-launch-1.0", "-q", *line.split()], capture_output=True, text=True, timeout=200,
                              stdin=subprocess.DEVNULL, env=WITHOUT_TRACERS)
        self.assertEqual(done.returncode, 0, done.stderr[-3000:])
        self.assertNotRegex(done.stderr, "CRITICAL|ERROR")
        text = (path or self.folder / "out.jsonl").read_text()
        return [json.loads(row, parse_constant=number) for row in text.splitlines()], done.stderr

    def found(self, outputs, decoder):
        frames, _ = self.play(self.line(outputs, decoder))
        self.assertEqual(len(frames), 1)
        return frames[0]

    def refused(self, outputs, decoder, *words):
        text = refusal(self, self.line(outputs, decoder))
        for word in ("error from weirtensordecoder0: ", *words):
            self.assertIn(word, text)

    def labels(self, count):
        path = self.folder / "labels.txt"
        path.write_text("".join(f"name {index}\n" for index in range(count)))
        return path


class Numbers(BadCase):
    def spoilt(self, head, entry, spoil):
        """The frames of all orders of a head whose floats went through `spoil`."""
        lines = []
        for index, order in enumerate(entry.orders):
            example = entry.encode(order, "float32")
            outputs = [(name, spoil(numpy.array(array, "f4")) if array.dtype.kind == "f" else array) for name, array in example.outputs]
            model = recording.write(self.folder / f"{index}.recorded", example.view.input, outputs, metadata=example.metadata)
            labels = self.folder / f"{index}.txt"
            labels.write_text("".join(label + "\n" for label in example.labels or []))
            custom = ",".join(filter(None, [f"head:{head}", example.custom]))
            (width, height), source = example.view.input, example.view.source
            lines.append(f"videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width={source[0]},height={source[1]} ! "
                         f"tensor_preprocess width={width} height={height} fit=letterbox type=uint8 ! "
                         f"tensor_filter framework=recorded model={model} ! tensor_decoder mode={entry.modes[-1]} custom={custom}"
                         + (f" labels={labels}" if example.labels else "")
                         + f" ! tensor_decoder mode=json ! filesink location={self.folder}/{index}.out")
        self.play("  ".join(lines), self.folder / "0.out")
        for index in range(len(entry.orders)):
            for text in (self.folder / f"{index}.out").read_text().splitlines():
                yield json.loads(text, parse_constant=number)

    def objects(self, frame):
        return frame.get("detections", []) + frame.get("labels", []) + frame.get("text", [])

    def test_outputs_that_are_not_numbers_hold_no_object(self):
        for head, entry in HEADS.items():
            with self.subTest(head=head):
                frames = list(self.spoilt(head, entry, lambda array: numpy.full_like(array, numpy.nan)))
                self.assertEqual(len(frames), len(entry.orders))
                if head != "class-map":  # whole numbers
                    self.assertEqual([self.objects(frame) for frame in frames], [[]] * len(frames))

    def test_infinite_outputs_give_finite_results(self):
        for head, entry in HEADS.items():
            for value in (numpy.inf, -numpy.inf):
                with self.subTest(head=head, value=value):
                    frames = list(self.spoilt(head, entry, lambda array: numpy.full_like(array, value)))
                    self.assertEqual(len(frames), len(entry.orders))

    def test_single_numbers_that_are_not_finite_leave_the_rest(self):
        random = numpy.random.default_rng(30)

        def spoil(array):
            bad = random.uniform(0, 1, array.shape) < 0.02
            array[bad] = random.choice([numpy.nan, numpy.inf, -numpy.inf], bad.sum())
            return array
        found, known = 0, 0
        for head, entry in HEADS.items():
            with self.subTest(head=head):
                for frame, order in zip(self.spoilt(head, entry, spoil), entry.orders):
                    found += len(self.objects(frame))
                    known += 0 if "segments" in frame else len(entry.encode(order, "float32").things)
        self.assertGreater(found, 0.7 * known, "2 of 100 numbers spoil some objects only")
        self.assertGreater(known, 150)


class Candidates(BadCase):
    def many(self, count):
        random, rows = numpy.random.default_rng(31), numpy.zeros((1, 9, count))
        rows[0, :2], rows[0, 2:4], rows[0, 4] = random.uniform(0, 320, (2, count)), 4, random.uniform(0.3, 0.9, count)
        return rows

    def test_none(self):
        self.assertEqual(self.found([("output0", self.many(2100) * 0)], "mode=detection")["detections"], [])

    def test_a_hundred_thousand_give_the_best_hundred(self):
        rows = self.many(100000)
        start = time.monotonic()
        found = self.found([("output0", rows)], "mode=detection iou=1 custom=head:yolov8")["detections"]
        self.assertLess(time.monotonic() - start, 20)
        best = sorted(rows[0, 4].astype("f4"))[:-101:-1]
        numpy.testing.assert_allclose([entry["score"] for entry in found], best, atol=1e-6)

    def test_a_hundred_thousand_at_one_place_are_one(self):
        rows = self.many(100000)
        rows[0, :4] = 50
        found = self.found([("output0", rows)], "mode=detection custom=head:yolov8")["detections"]
        self.assertEqual(len(found), 1)
        self.assertAlmostEqual(found[0]["score"], rows[0, 4].max(), places=6)


class Sizes(BadCase):
    def seg(self, *extents):
        (name, rows), (_, prototypes) = yolo.yolov8_seg("planes", "float32").outputs
        return [(name, rows), ("output1", prototypes[extents] if extents else prototypes)]

    def test_an_input_of_size_zero(self):
        outputs = yolo.yolov8("planes", "float32").outputs
        self.refused(outputs, "mode=detection custom=input:0:0", "WEIR-1004", "offered: input=0:0",
                     "each from 1 to 32767", "fix: input=640:480")

    def test_an_output_without_elements(self):
        self.refused([("output0", numpy.zeros((1, 9, 0)))], "mode=detection custom=head:yolov8", "WEIR-2001",
                     "the outputs are not those of the head yolov8", "float32 1:9:1 'output0'")

    def test_caps_with_an_extent_of_zero(self):
        text = refusal(self, "filesrc location=/dev/zero blocksize=4 num-buffers=1 ! application/octet-stream ! "
                             "tensor_converter input-dim=0:9 input-type=float32 ! tensor_decoder mode=detection ! fakesink")
        self.assertIn("error from weirtensorconverter0: WEIR-", text)
        self.assertIn("0:9", text)

    def test_masks_of_half_the_size_are_as_good(self):
        self.assertEqual(len(self.found(self.seg(..., slice(None, None, 2), slice(None, None, 2)), "mode=segmentation")["detections"]), 3)

    def test_masks_of_another_aspect(self):
        self.refused(self.seg(..., slice(60), slice(None)), "mode=segmentation custom=head:yolov8-seg", "WEIR-2001",
                     "the outputs are not those of the head yolov8-seg", "float32 80:60:8:1 'output1'", "prototypes W:H:M or M:W:H",
                     "fix: tensor_decoder without custom=head:yolov8-seg")
        self.refused(self.seg(..., slice(60), slice(None)), "mode=segmentation", "no head of this mode fits these outputs",
                     "yolov8-seg: N:4+CLASSES+M")

    def test_more_masks_than_a_row_has_weights(self):
        (rows, prototypes) = self.seg()
        self.refused([rows, ("output1", numpy.tile(prototypes[1], (1, 2, 1, 1)))], "mode=segmentation custom=head:yolov8-seg",
                     "the outputs are not those of the head yolov8-seg", "80:80:16:1")

    def test_masks_are_missing(self):
        self.refused(self.seg()[:1], "mode=segmentation custom=head:yolov8-seg", "the outputs are not those of the head yolov8-seg")


class Labels(BadCase):
    def test_a_class_beyond_the_labels_is_its_number(self):
        line = self.line(yolo.yolov8("planes", "float32").outputs, f"mode=detection labels={self.labels(2)}")
        frames, _ = self.play(line.replace("mode=json", f"mode=json labels={self.labels(2)}"))
        self.assertEqual({entry["label"] for entry in frames[0]["detections"]}, {"name 0", "name 1", "2"})

    def test_classes_that_no_label_names(self):
        self.refused(yolo.yolov8("planes", "float32").outputs, f"mode=detection labels={self.labels(2)} classes=zebra",
                     "WEIR-1004", "a class is neither a label nor a number", "offered: classes=zebra", "one of the 2 labels")

    def test_a_dictionary_of_another_length(self):
        steps = numpy.zeros((1, 8, 29))
        for count in (0, 20, 40):
            labels = f" labels={self.labels(count)}" if count else ""
            self.refused([("softmax", steps)], f"mode=text custom=head:ctc{labels}", f"offered: {count} characters",
                         "27 or 28 characters for 29 classes", "fix: tensor_decoder labels=/path/to/dictionary.txt")


@unittest.skipUnless(has_engine("onnxruntime"), "the engine onnxruntime is not built")
class Cards(BadCase):
    INPUT = {"type": "float32", "shape": [1, 3, 320, 320], "layout": "NCHW", "color": "RGB", "resize": "letterbox"}

    def setUp(self):
        super().setUp()
        self.model = self.folder / "net.onnx"
        rows = yolo.yolov8("planes", "float32").outputs[0][1]
        self.model.write_bytes(onnx_writer.model([("Identity", ["rows"], "output0")], {"rows": rows}, [("images", (1, 3, 320, 320))],
                                                 [("output0", rows.shape)]))
        self.card = {"name": "net", "model": "net.onnx", "task": "detection", "inputs": [self.INPUT], "provenance": {},
                     "sha256": hashlib.sha256(self.model.read_bytes()).hexdigest(), "decoder": "detection", "outputs": [],
                     "decoder_options": {"custom": "head:yolov8"}, "labels": ["a", "b", "c", "d", "e"]}

    def tried(self, **changes):
        (self.folder / "net.card.json").write_text(json.dumps(self.card | changes))
        return subprocess.run([os.environ["WEIR_COMMAND"], "try", "--json", self.model, "test"], capture_output=True, text=True,
                              timeout=100, env=WITHOUT_TRACERS | {"WEIR_CARD_PATH": ""})

    def refused_card(self, words, **changes):
        done = self.tried(**changes)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_a_card_that_fits(self):
        done = self.tried()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([entry["label"] for entry in json.loads(done.stdout.splitlines()[0])["detections"]], ["c", "a", "b"])

    def test_another_size(self):
        self.refused_card(["error from tensor_filter0: WEIR-2001: the stream does not fit the model",
                           "dimension 0 is 256, needed is 320"],
                          inputs=[self.INPUT | {"shape": [1, 3, 256, 256]}])

    def test_another_type(self):
        self.refused_card(["WEIR-2001: the stream does not fit the model", "type is uint8, needed is float32"],
                          inputs=[self.INPUT | {"type": "uint8"}])

    def test_another_layout(self):
        self.refused_card(["WEIR-2001: the stream does not fit the model", "dimension 0 is 3, needed is 320"],
                          inputs=[self.INPUT | {"shape": [1, 320, 320, 3], "layout": "NHWC"}])

    def test_another_mode(self):
        self.refused_card(["error from tensor_decoder0: WEIR-2001: no head of this mode fits these outputs"],
                          decoder="pose", decoder_options={})

    def test_another_head(self):
        self.refused_card(["error from tensor_decoder0: WEIR-2001: the outputs are not those of the head ssd",
                           "fix: tensor_decoder without custom=head:ssd"], decoder_options={"custom": "head:ssd"})

    def test_another_file(self):
        self.refused_card(["WEIR-3009: the card next to the model belongs to a different file", "net.card.json: sha256 00000000",
                           f"needed: sha256 {self.card['sha256']}: if you trained the model again", "fix: sed -i s/000"], sha256="0" * 64)


if __name__ == "__main__":
    tap_runner.main()
