#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scores tensor_tracker on the sequences of docs/tracking.md, beside a plain IoU tracker.

The boxes go through whole pipelines. The scores are those of an independent implementation (metrics.py); weir evaluate must agree.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy
import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
COMMAND = os.environ["WEIR_COMMAND"]
README = SOURCE / "src/elements/tensor_tracker/README.md"
TOOLS = SOURCE / "tools/tracking"
sys.path.insert(0, str(TOOLS))
import metrics  # noqa: E402
import plain_iou  # noqa: E402
import sequences  # noqa: E402

SEEDS = (1, 2)
SCORES = ("MOTA", "IDF1", "HOTA")


def truth_of(frames):
    return [{int(n): box for n, box, part in zip(f.numbers, f.boxes, f.visible) if part >= sequences.HIDDEN} for f in frames]


def followed(frames, tracker, folder):
    """The tracks that a pipeline with `tracker` finds: for each frame a dict of number: box. Tensor 1 has the embeddings."""
    most, length = max(len(frame.found) for frame in frames), sequences.EMBEDDING
    rows = numpy.zeros((len(frames), most * (5 + length)), numpy.float32)
    for i, frame in enumerate(frames):
        rows[i, :frame.found.size] = frame.found.ravel()
        rows[i, 5 * most:5 * most + frame.embeddings.size] = frame.embeddings.ravel()
    rows.tofile(folder / "rows")
    subprocess.run(["gst-launch-1.0", "-q", *(
        f"filesrc location={folder}/rows blocksize={rows[0].nbytes} ! application/octet-stream,framerate={sequences.RATE}/1 ! "
        f"tensor_converter input-dim=5:{most},{length}:{most} input-type=float32,float32 ! other/tensors,weir-columns=(string)\"x1,y1,x2,y2,score\" ! "
        f"{tracker} ! tensor_decoder mode=mot ! filesink location={folder}/tracks").split()], check=True, timeout=60,
        env={**os.environ, "GST_TRACERS": "", "GST_DEBUG": ""})
    out = [{} for _ in frames]
    for line in (folder / "tracks").read_text().splitlines():
        frame, number, x, y, width, height = map(float, line.split(",")[:6])
        if number > 0:
            out[int(frame) - 1][int(number)] = [x - 1, y - 1, x - 1 + width, y - 1 + height]
    return out


class Sequences(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.made = {name: [sequences.make(scene, seed) for seed in SEEDS] for name, scene in sequences.SCENES.items()}


class Order(Sequences):
    """The margins are about half of what was measured; a tracker that loses that much is broken."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scores = {name: {key: cls.score(made, key) for key in ("bytetrack", "iou", "plain")} for name, made in cls.made.items()}

    @classmethod
    def score(cls, made, key):
        found = [plain_iou.follow([frame.found for frame in frames]) if key == "plain" else
                 followed(frames, f"tensor_tracker mode={key}", cls.folder) for frames in made]
        return metrics.scores([list(zip(truth_of(frames), tracks)) for frames, tracks in zip(made, found)])

    def better(self, name, key, idf1, hota):
        ours, other = self.scores[name]["bytetrack"], self.scores[name][key]
        self.assertGreater(ours["IDF1"], other["IDF1"] + idf1, (name, key, ours, other))
        self.assertGreater(ours["HOTA"], other["HOTA"] + hota, (name, key, ours, other))

    def test_crossings_and_occlusion(self):
        for name in ("crossings", "occlusion"):
            for key in ("iou", "plain"):
                self.better(name, key, 0.12, 0.1)
                self.assertLess(3 * self.scores[name]["bytetrack"]["switches"], self.scores[name][key]["switches"])

    def test_nothing_is_worse_than_the_plain_tracker(self):
        for name in self.scores:
            with self.subTest(name):
                self.better(name, "plain", 0, 0)
                self.assertGreater(self.scores[name]["bytetrack"]["MOTA"], self.scores[name]["plain"]["MOTA"] - 0.005)

    def test_the_mode_iou_is_like_the_plain_tracker(self):
        """Two programs of the same kind: one assigns optimally, the other the best pair first."""
        for name, found in self.scores.items():
            for score in SCORES:
                self.assertAlmostEqual(found["iou"][score], found["plain"][score], delta=0.08, msg=(name, score))

    def test_the_camera_is_compensated(self):
        self.better("shake", "plain", 0.14, 0.1)

    def test_embeddings_exchange_fewer_numbers(self):
        found = {name: metrics.scores([list(zip(truth_of(frames), followed(frames, "tensor_tracker embeddings=1", self.folder))) for frames in made])
                 for name, made in self.made.items()}
        switches = [sum(scores["switches"] for scores in all_scores) for all_scores in
                    (found.values(), [scores["bytetrack"] for scores in self.scores.values()])]
        self.assertLess(3 * switches[0], 2 * switches[1], switches)
        self.assertGreater(found["all"]["IDF1"], self.scores["all"]["bytetrack"]["IDF1"] + 0.05)
        for name, scores in found.items():
            self.assertGreater(scores["IDF1"], self.scores[name]["bytetrack"]["IDF1"] - 0.005, name)

    def test_the_table_of_the_readme(self):
        measured = {name: [found[key][score] for key in ("bytetrack", "iou", "plain") for score in SCORES] for name, found in self.scores.items()}
        shown = "\n".join(f"| `{name}` | " + " | ".join(f"{value:.3f}" for value in values) + " |" for name, values in measured.items())
        rows = dict(re.findall(r"(?m)^\| `([a-z-]+)` ((?:\| [01]\.\d{3} ){9})\|$", README.read_text()))
        self.assertEqual(list(rows), list(measured), "the table as measured:\n" + shown)
        for name, values in measured.items():
            numpy.testing.assert_allclose([float(cell) for cell in rows[name].split("|")[1:]], values, atol=0.005,
                                          err_msg="the table as measured:\n" + shown)


@unittest.skipUnless(has_engine("python3"), "the filter that stands in for a detector needs the engine python3")
class Evaluate(Sequences):
    def test_agrees_with_the_definitions(self):
        """To 1e-6, on a sequence of each scene; the boxes of the JSON are those of the stream."""
        for name, made in self.made.items():
            with self.subTest(name):
                sequence = self.folder / f"{name}-{SEEDS[0]}"
                sequences.write(sequence, made[0], pictures=True)
                done = subprocess.run(
                    [COMMAND, "evaluate", "--json", f"tensor_converter ! tensor_filter framework=python3 model={TOOLS}/found_boxes.py "
                     f'custom={sequence}/det/det.txt ! other/tensors,weir-columns=(string)"x1,y1,x2,y2,score" ! tensor_tracker', sequence],
                    capture_output=True, text=True, timeout=60, env={**os.environ, "GST_TRACERS": "", "GST_DEBUG": ""})
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                found = json.loads(done.stdout)["results"][0]["scores"]
                ours = metrics.scores([list(zip(truth_of(made[0]), followed(made[0], "tensor_tracker", self.folder)))])
                for score in (*SCORES, "switches"):
                    self.assertAlmostEqual(found[score], ours[score], delta=1e-6, msg=score)


if __name__ == "__main__":
    tap_runner.main()
