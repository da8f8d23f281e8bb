#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cards, models and files of others: what they cannot do in weir try, evaluate, inspect and bench, and what they still can."""

import hashlib
import json
import os
import re
import shlex
import subprocess
import unittest

import numpy
import onnx_writer
import tap_runner
from PIL import Image
from weir_case import HAS_ONNX, SANITIZED, SOURCE, WITHOUT_LEAKS, Case, weir

THREE_CLASSES = ["dark", "grey", "light"]
# What follows "classification" continues the pipeline, when a mode becomes a part of its text.
SECOND = ("! fakesink filesrc location={secret} ! filesink location={stolen} videotestsrc num-buffers=1 ! "
          "video/x-raw,format=BGRx,width=1,height=1 ! tensor_converter ! tensor_transform mode=typecast option=float32")
SCRIPT = """open({ran!r}, "w").write("x")
class CustomDecoder(object):
  def getOutCaps(self): return b"application/octet-stream"
  def decode(self, *a): return b"x"
"""


class Strange(Case):
    def setUp(self):
        super().setUp()
        self.model, self.picture = self.folder / "m.onnx", self.folder / "picture.png"
        # Three scores for pictures of 8 x 8: the mean of the pixels, times a weight for each class.
        self.model.write_bytes(onnx_writer.model(
            [("ReduceMean", ("image",), "mean"), ("Flatten", ("mean",), "one"), ("MatMul", ("one", "w"), "scores")],
            {"w": numpy.array([[0.1, 0.2, 0.3]], "f")}, [("image", (1, 3, 8, 8))], [("scores", (1, 3))]))
        Image.new("RGB", (8, 8), "white").save(self.picture)
        self.stolen, self.ran = self.folder / "stolen.txt", self.folder / "RAN"
        (self.folder / "secret.txt").write_text("secret")
        self.environment = {"WEIR_CARD_PATH": str(self.folder / "none"), "XDG_CACHE_HOME": str(self.folder / "cache"), **WITHOUT_LEAKS}

    def write_card(self, beside=None, **fields):
        model = beside or self.model
        card = {"name": "m", "model": model.name.replace("\n", " "), "sha256": hashlib.sha256(model.read_bytes()).hexdigest(), "task": "x",
                "inputs": [{"name": "image", "type": "float32", "shape": [1, 3, 8, 8], "layout": "NCHW", "color": "RGB"}],
                "decoder": "classification", "provenance": {"source": "x", "licence": "x"}, **fields}
        model.with_suffix(".card.json").write_text(json.dumps(card))

    def second_pipeline(self):
        return SECOND.format(secret=self.folder / "secret.txt", stolen=self.stolen)

    def labelled_folder(self):
        for shade, name in enumerate(THREE_CLASSES):
            (self.folder / "set" / name).mkdir(parents=True, exist_ok=True)
            Image.new("RGB", (8, 8), (shade, 0, 0)).save(self.folder / "set" / name / f"{name}.png")
        return self.folder / "set"

    def commands(self):
        """Every command that reads the card of a model."""
        folder = self.labelled_folder()
        return [("try", self.model, self.picture), ("try", self.model, self.picture, "--output", self.folder / "o.png"),
                ("evaluate", self.model, folder), ("inspect", self.model), ("inspect", "--json", self.model)]

    def all_refuse(self, *texts):
        for arguments in self.commands():
            with self.subTest(arguments[0]):
                done = weir(*arguments, **self.environment)
                printed = done.stdout + done.stderr
                if arguments[0] != "inspect":  # which describes models with faulty cards, too
                    self.assertEqual(done.returncode, 1, printed)
                for text in ("WEIR-3009", *texts):
                    self.assertIn(text if "--json" not in arguments else json.dumps(text)[1:-1], printed)
                self.assertFalse(self.stolen.exists(), "the card wrote a file")
                self.assertFalse(self.ran.exists(), "the card ran a script")


@unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
class Refused(Strange):
    def test_a_mode_that_continues_the_pipeline(self):
        self.write_card(decoder="classification " + self.second_pipeline())
        self.all_refuse("m.card.json/decoder: ", "null, or a mode that comes with Weir: image_labeling, detection, classification")

    def test_the_name_of_an_option_that_continues_the_pipeline(self):
        self.write_card(decoder_options={self.second_pipeline() + " name": "x"})
        self.all_refuse("m.card.json/decoder_options/! fakesink", "mode=classification has threshold, iou, labels")

    def test_the_value_of_an_option_that_continues_the_pipeline(self):
        self.write_card(decoder_options={"classes": "light\" " + self.second_pipeline()}, labels=THREE_CLASSES)
        for arguments in self.commands()[:3]:
            self.refused(weir(*arguments, **self.environment), 1, "a class is neither a label nor a number", 'offered: classes=light" ! fakesink')
            self.assertFalse(self.stolen.exists(), "the card wrote a file")

    def test_a_script(self):
        script = self.folder / "d.py"
        script.write_text(SCRIPT.format(ran=str(self.ran)))
        for name in (str(script), "d.py"):
            self.write_card(decoder="python3", decoder_options={"option1": name})
            self.all_refuse('m.card.json/decoder: "python3"', "a mode that runs no code",
                            "write tensor_decoder mode=python3 option1=/path/to/script.py into a pipeline")

    def test_files_of_other_folders(self):
        for decoder, options in (("classification", {"labels": str(self.folder / "secret.txt")}),
                                 ("classification", {"custom": f"labels:{self.folder}/secret.txt"}),
                                 ("detection", {"custom": "head:ssd,priors:../secret.txt"}),
                                 ("image_labeling", {"option1": "/etc/passwd"})):
            self.write_card(decoder=decoder, decoder_options=options)
            done = weir("try", self.model, self.picture, **self.environment)
            self.refused(done, 1, "WEIR-3009", "the name of a file beside the card, without folders; for any other file, use ")
        self.assertNotIn("secret\n", done.stdout + done.stderr)

    def test_other_properties_of_the_element(self):
        for name in ("config-file", "mode", "name", "max-buffer-size"):
            self.write_card(decoder_options={name: str(self.folder / "secret.txt")})
            self.refused(weir("try", self.model, self.picture, **self.environment), 1, f"m.card.json/decoder_options/{name}: ",
                         "mode=classification has threshold, iou, labels, max-results, classes, custom")

    def test_numbers_that_are_no_shape(self):
        for shape in ([1, 3, 8.9, 8], [1, 3, -8, 8], [1, 3, 1e300, 8], [1, 3, "8", 8], [1, 3, None, 8], "8"):
            self.write_card(inputs=[{"type": "float32", "shape": shape, "layout": "NCHW", "color": "RGB"}])
            self.refused(weir("try", self.model, self.picture, **self.environment), 1, "WEIR-3009",
                         f"m.card.json/inputs/0/shape: {json.dumps(shape).replace(', ', ',')}")

    def test_texts_of_every_field_that_would_become_pipeline_text(self):
        text = "RGB ! fakesink"
        for field in ("type", "layout", "color", "resize"):
            picture = {"type": "float32", "shape": [1, 3, 8, 8], "layout": "NCHW", "color": "RGB", field: text}
            self.write_card(inputs=[picture])
            self.refused(weir("try", self.model, self.picture, **self.environment), 1, f'm.card.json/inputs/0/{field}: "{text}"')


@unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
class Accepted(Strange):
    def labels(self, *arguments, **environment):
        done = weir("try", "--json", *arguments, **{**self.environment, **environment})
        frame = json.loads(self.good(done))
        return [found["label"] for found in frame["labels"]], done.stderr

    def test_a_mode_with_options_and_a_label_file_beside_the_card(self):
        (self.folder / "my labels.txt").write_text("\n".join(THREE_CLASSES) + "\n")
        self.write_card(decoder_options={"labels": "my labels.txt", "max-results": "2", "threshold": "0", "custom": "head:classifier"})
        names, line = self.labels(self.model, self.picture)
        self.assertEqual(names, ["light", "grey"])
        self.assertIn(f"labels='\"{self.folder}/my labels.txt\"'", line)

    def test_evaluate_with_options_of_the_card(self):
        self.write_card(labels=THREE_CLASSES, decoder_options={"custom": "head:classifier"})
        done = weir("evaluate", "--json", self.model, self.labelled_folder(), **self.environment)
        self.assertEqual(len(json.loads(self.good(done))["results"]), 1)

    def test_the_users_mode_and_labels_count(self):
        (self.folder / "of the user.txt").write_text("a\nb\nc\n")
        self.write_card(decoder="detection", decoder_options={"custom": "head:yolox"}, labels=THREE_CLASSES)
        names, _ = self.labels(self.model, self.picture, "--mode", "classification", "--labels", self.folder / "of the user.txt")
        self.assertEqual(names[0], "c")

    def test_files_with_any_name(self):
        """As model, card and picture; the printed line finds the same files in a shell."""
        self.write_card(labels=THREE_CLASSES)
        for name in ("a b", "it's", 'a "b"', "a ! fakesink", "$(touch RAN)", "`touch RAN`", "a;b", "a&b", "\\", "b\\", "a\nb", "NULL",
                     "#", "caf\u00e9", "\"q\" \\", "x=y", "'", "*"):
            with self.subTest(name):
                folder = self.folder / "any" / name
                folder.mkdir(parents=True)
                model, picture = folder / f"{name}.onnx", folder / f"{name}.png"
                model.write_bytes(self.model.read_bytes())
                picture.write_bytes(self.picture.read_bytes())
                self.write_card(model, labels=THREE_CLASSES)
                names, printed = self.labels(model, picture)
                self.assertEqual(names[0], "light")
                self.assertFalse(self.ran.exists())
                line = printed[printed.index("gst-launch-1.0 "):].rstrip("\n")
                if SANITIZED:
                    continue
                pasted = subprocess.run(["sh", "-c", line.replace("gst-launch-1.0 ", "gst-launch-1.0 -q ")], capture_output=True,
                                        text=True, timeout=60, cwd=self.folder, env={**os.environ, **self.environment})
                self.assertEqual(pasted.returncode, 0, line + pasted.stderr)
                self.assertEqual(json.loads(pasted.stdout)["labels"][0]["label"], "light", line)
                self.assertFalse(self.ran.exists(), line)

    def test_the_line_of_inspect_has_any_file(self):
        for name in ("a ! b", "$(touch RAN)", "it's", "b\\", "a\nb"):
            folder = self.folder / name
            folder.mkdir()
            model = folder / "m.onnx"
            model.write_bytes(self.model.read_bytes())
            self.write_card(model, labels=THREE_CLASSES)
            line = json.loads(self.good(weir("inspect", "--json", model, **self.environment)))["launch"]
            self.assertEqual(shlex.split(line)[0], "gst-launch-1.0")
            if not SANITIZED:
                self.runs(line.replace("num-buffers=30", "num-buffers=1"), **self.environment)
            self.assertFalse(self.ran.exists(), line)

    def test_the_line_of_serve_has_any_file(self):
        for name in ("a ! b", "$(touch RAN)", "it's", 'a" ! fakesink "', "b\\"):
            model = self.folder / f"{name}.onnx"
            model.write_bytes(self.model.read_bytes())
            words = shlex.split(self.good(weir("serve", "--dry-run", f"m={model}", **self.environment)))
            self.assertEqual([words.count("!"), words[-2:]], [2, ["name=m-sink", "id=1"]], words)
            quoted = next(word for word in words if word.startswith("model="))
            self.assertEqual(re.sub(r"\\(.)", r"\1", quoted.removeprefix("model=").strip('"')), str(model))

    def test_every_card_that_comes_with_weir(self):
        cards = sorted((SOURCE / "models").rglob("*.card.json"))
        self.assertGreater(len(cards), 20)
        self.good(weir("run", " ".join(f"videotestsrc num-buffers=1 ! tensor_preprocess card={card} ! fakesink" for card in cards)))

    def test_names_in_the_model_file_do_not_reach_the_terminal(self):
        """Names of tensors; weir() checks that nothing controls the terminal."""
        model = self.folder / "names.onnx"
        image = "image\x1b[2J\r$(touch RAN)"
        model.write_bytes(onnx_writer.model([("Relu", (image,), "out\x1b]0;x\x07")], {}, [(image, (1, 3, 8, 8))],
                                            [("out\x1b]0;x\x07", (1, 3, 8, 8))]))
        for arguments in (("inspect", model), ("card", model, "--output", "-"), ("try", model, self.picture),
                          ("try", "--mode", "pose", model, self.picture)):
            done = weir(*arguments, **self.environment)
            self.assertNotRegex(done.stdout + done.stderr, "[\x00-\x08\x0b-\x1f\x7f]")

    def test_labels_do_not_reach_the_terminal(self):
        (self.folder / "l.txt").write_text("a\x1b[2J\nb\x1b[2J\nc\x1b[2J\n")
        self.write_card(decoder_options={"labels": "l.txt"})
        done = weir("try", self.model, self.picture, **self.environment)
        self.assertIn("c\\x1b[2J", self.good(done))
        self.write_card(labels=["a\x1b[2J", "b", "c"])
        self.refused(weir("try", self.model, self.picture, **self.environment), 1, "m.card.json/labels/0: ")


if __name__ == "__main__":
    tap_runner.main()
