#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds the column "run on" of docs/heads.md to the weights that are here: each is read by the head whose row names it.

Models of the catalogue are found by their digests, in WEIR_DATA/models, WEIR_MODELS and WEIR_NPM_MODELS; other files by name.
"""

import hashlib
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import tap_runner
from built_modules import has_engine
from examples import HEADS

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
MODELS = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared") / "models"
FOLDERS = [MODELS, *(pathlib.Path(os.environ[name]) for name in ("WEIR_MODELS", "WEIR_NPM_MODELS") if os.environ.get(name))]
ENGINES = {".onnx": "onnxruntime", ".tflite": "tensorflow-lite"}
TASKS = ("classification", "detection", "pose", "segmentation", "text")
ENVIRONMENT = {key: value for key, value in os.environ.items() if key not in ("GST_TRACERS", "GST_DEBUG")} | {
    "WEIR_CARD_PATH": str(SOURCE / "models" / "cards")}


def rows():
    """The names in the last column of each head; none for "head only"."""
    found = {}
    for line in (SOURCE / "docs/heads.md").read_text().split("## Settings")[0].splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if re.fullmatch("`[^`]+`", cells[0]) and cells[0] != "`head`":
            found[cells[0].strip("`")] = cells[-1]
    return found


@unittest.skipUnless(MODELS.is_dir(), f"{MODELS} is not there")
class Table(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.picture = self.folder / "picture.png"
        subprocess.run(["gst-launch-1.0", "-q", *(f"videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=320,height=240 ! pngenc ! "
                                                  f"filesink location={self.picture}").split()], check=True, env=ENVIRONMENT)
        self.catalogue = {model["name"]: model for model in json.loads((SOURCE / "models/catalogue.json").read_text())["models"]}
        self.files = {}
        for path in (path for base in FOLDERS for path in sorted(base.rglob("*")) if path.is_file()):
            self.files.setdefault(path.name, path)
            self.files.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path)

    def file_of(self, name):
        """The file of a model that the table names, beside the other files of the model; None where it is not here."""
        wanted = self.catalogue[name]["files"] if name in self.catalogue else [{"name": name, "sha256": name}]
        paths = [self.files.get(file["sha256"]) for file in wanted]
        if not all(paths) or not has_engine(ENGINES[paths[0].suffix]):
            return None
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        for file, path in zip(wanted, paths):
            if not (folder / file["name"]).exists():
                (folder / file["name"]).symlink_to(path)
        return folder / wanted[0]["name"]

    def tried(self, path, *options):
        labels = next(path.parent.glob("*keys*.txt"), None)
        return subprocess.run([os.environ["WEIR_COMMAND"], "try", "--json", *options, *(["--labels", labels] if labels else []), path,
                               self.picture], capture_output=True, text=True, timeout=200, env=ENVIRONMENT, check=False)

    def test_each_head_has_a_row(self):
        self.assertEqual(set(rows()), set(HEADS))

    def test_the_named_weights_are_read_by_their_head(self):
        run = 0
        tests = "".join((SOURCE / "tests/pipelines" / f"{name}_test.py").read_text() for name in ("heads", "landmark_heads"))
        for head, cell in rows().items():
            if cell == "head only":
                continue
            self.assertRegex(cell, r"^`[^`]+`(, `[^`]+`)*$", head)
            for name in re.findall("`([^`]+)`", cell):
                with self.subTest(head=head, model=name):
                    if name not in self.catalogue:
                        self.assertIn(name, tests, "neither in the catalogue nor in a test")
                    path = self.file_of(name)
                    if not path:
                        continue
                    done = self.tried(path, "--mode", HEADS[head].modes[-1], "--head", head)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertIn(f"by the head {head}\n", done.stderr)
                    run += 1
        if has_engine("onnxruntime") and has_engine("tensorflow-lite"):
            self.assertGreaterEqual(run, 20)

    def test_every_model_that_is_here_is_in_the_row_of_its_head(self):
        for name, model in self.catalogue.items():
            path = self.file_of(name) if model["task"] in TASKS else None
            if not path:
                continue
            with self.subTest(model=name):
                text = self.tried(path, "--mode", model["task"]).stderr
                card = json.loads((SOURCE / "models/cards" / model["card"]).read_text())
                # The outputs of a model without fixed input are not known before its first frame.
                heads = re.findall(r"by the head (\S+)", text) or re.findall(r"head:([\w-]+)", str(card.get("decoder_options", ""))) or \
                    [head for several in re.findall("fit several heads: (.*)", text) for head in several.split(", ")]
                self.assertIn(f"`{name}`", " ".join(cell for head, cell in rows().items() if head in heads or not heads), text)


if __name__ == "__main__":
    tap_runner.main()
