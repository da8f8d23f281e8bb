#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir evaluate with photos that say how they must be turned, and with a card that lacks how pixels are prepared."""

import hashlib
import json
import unittest

import numpy
import onnx_writer
import tap_runner
from evaluation_case import SIZE, Coco, scores, write_picture
from PIL import Image
from weir_case import HAS_ONNX, WITHOUT_LEAKS, Case, weir


class Photos(Coco):
    def add_photo(self, orientation, transposed=None):
        """A photo whose upright picture has the box of the truth; its pixels are stored transposed."""
        self.add([(0, 20, 30, 100, 200)], [])
        image = self.truth["images"][-1]
        (self.folder / "set" / image["file_name"]).unlink()
        image |= {"file_name": f"{orientation}.jpg", "height": 2 * SIZE[1]}
        upright = self.folder / "upright.png"
        write_picture(upright, [[20, 30, 120, 230, 200, 0]], (SIZE[0], 2 * SIZE[1]))
        exif = Image.Exif()
        exif[0x0112] = orientation
        picture = Image.open(upright)
        if transposed is not None:
            picture = picture.transpose(transposed)
        picture.save(self.folder / "set" / image["file_name"], quality=100, exif=exif)
        return self.folder / "set" / image["file_name"]

    def test_are_turned_as_their_exif_orientation_says(self):
        """All eight orientations. Pillow's rotations are counter-clockwise: 6 says that the photo must be turned clockwise."""
        turns = Image.Transpose
        stored = (None, turns.FLIP_LEFT_RIGHT, turns.ROTATE_180, turns.FLIP_TOP_BOTTOM, turns.TRANSPOSE, turns.ROTATE_90, turns.TRANSVERSE,
                  turns.ROTATE_270)
        for orientation, transposed in enumerate(stored, 1):
            self.add_photo(orientation, transposed)
        self.write()
        done = self.evaluate("--json")
        self.assertEqual((scores(done)["AP50"], scores(done)["AP75"]), (1, 1), done.stdout)
        self.assertEqual(json.loads(done.stdout)["pictures"], 8, done.stderr)

    def test_the_truth_of_the_stored_pixels_does_not_fit(self):
        self.add_photo(1)
        self.add_photo(6, Image.Transpose.ROTATE_90)
        image = self.truth["images"][-1]
        image["width"], image["height"] = image["height"], image["width"]
        self.write()
        done = self.evaluate()
        self.assertRegex(self.good(done), "ap of 1 picture,")
        self.assertIn("6.jpg: 280 x 560 pixels", done.stderr)

    def test_damaged_exif_data_is_not_followed(self):
        """A damaged name or header: the photo is as its pixels are."""
        photo = self.add_photo(3)
        self.write()
        whole = photo.read_bytes()
        start = whole.index(b"Exif")
        for at in (start, start + 6):
            photo.write_bytes(whole[:at] + b"\xff\xff" + whole[at + 2:])
            done = self.evaluate("--json")
            self.assertEqual(done.returncode, 0, (at - start, done.stdout, done.stderr))
            self.assertEqual(scores(done)["AP50"], 1, at - start)

@unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
class OwnModel(Case):
    def test_a_card_without_mean_and_scale_is_an_accuracy_of_zero(self):
        """Trained on pixels of 0 to 1: others are 2 m - 1.2, which is more than the mean m if pixels are bytes."""
        model, labels = self.folder / "own.onnx", ["dark", "light", *(f"other {i}" for i in range(6))]
        weights = numpy.array([[0, 1] + 6 * [2]], "f")
        bias = numpy.array([[0.5, 0] + [-1.2] * 6], "f")
        model.write_bytes(onnx_writer.model(
            [("ReduceMean", ("image",), "mean"), ("Flatten", ("mean",), "one"), ("MatMul", ("one", "w"), "m"), ("Add", ("m", "b"), "scores")],
            {"w": weights, "b": bias}, [("image", (1, 3, 8, 8))], [("scores", (1, 8))]))
        for grey, name in ((40, "dark"), (250, "light")):
            (self.folder / "set" / name).mkdir(parents=True)
            Image.new("RGB", (8, 8), (grey, grey, grey)).save(self.folder / "set" / name / "one.png")
        card = {"name": "own", "model": "own.onnx", "sha256": hashlib.sha256(model.read_bytes()).hexdigest(), "task": "x",
                "inputs": [{"name": "image", "type": "float32", "shape": [1, 3, 8, 8], "layout": "NCHW", "color": "RGB"}],
                "decoder": "classification", "labels": labels, "provenance": {"source": "x", "licence": "x"}}
        for scale, accuracy in (([1 / 255], 1), ([], 0)):
            card["inputs"][0]["scale"] = scale
            model.with_suffix(".card.json").write_text(json.dumps(card))
            done = weir("evaluate", model, self.folder / "set", "--json", **WITHOUT_LEAKS)
            self.assertEqual(scores(done)["top-1"], accuracy, done.stderr)
            self.assertEqual("although the model has such classes" in done.stdout, accuracy == 0)


if __name__ == "__main__":
    tap_runner.main()
