#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir evaluate: the scores of tracks against NumPy, and sequences that it refuses."""

import json
import shutil

import numpy
import reference_metrics as reference
import tap_runner
from evaluation_case import BOXES, SIZE, WHOLE, scores, write_picture
from weir_case import WITHOUT_LEAKS, Case, weir


class Tracks(Case):
    def add(self, name, frames, truth, rate=10, **settings):
        """frames: dicts of track: x, y, width, height that are found; truth: likewise."""
        folder = self.folder / "set" / name
        lines = []
        for i, (boxes, found) in enumerate(zip(truth, frames), 1):
            rows = [[x, y, x + w, y + h, 200, 0, track] for track, (x, y, w, h) in found.items()]
            write_picture(folder / "img1" / f"{i:06}.png", rows)
            lines += [f"{i},{track},{x + 1},{y + 1},{w},{h},1,1,1" for track, (x, y, w, h) in boxes.items()]
        (folder / "gt").mkdir()
        (folder / "gt" / "gt.txt").write_text("\n".join(lines))
        info = {"name": name, "imDir": "img1", "frameRate": rate, "seqLength": len(frames), "imWidth": SIZE[0], "imHeight": SIZE[1],
                "imExt": ".png", **settings}
        (folder / "seqinfo.ini").write_text("[Sequence]\n" + "".join(f"{k}={v}\n" for k, v in info.items()))

    def evaluate(self, *options, pipeline=BOXES):
        return weir("evaluate", pipeline, self.folder / "set", *options, **WITHOUT_LEAKS)

    def random_sequence(self, seed, length=25, objects=4):
        """Objects that move, are missed, change their numbers and swap them; false boxes."""
        random = numpy.random.default_rng(seed)
        truth, frames = [], []
        places = random.integers(20, 180, (objects, 2)).astype(float)
        speeds = random.normal(0, 3, (objects, 2))
        ids = list(range(11, 11 + objects))
        for frame in range(length):
            places = numpy.clip(places + speeds, 5, 200)
            if random.random() < 0.2:
                a, b = random.choice(objects, 2, replace=False)
                ids[a], ids[b] = ids[b], ids[a]
            if random.random() < 0.1:
                ids[random.integers(objects)] = 30 + frame
            there = [o for o in range(objects) if not (o == 1 and frame < 6)]
            truth.append({o + 1: tuple(int(n) for n in (*places[o], 40, 50)) for o in there})
            found = {}
            for o in there:
                if random.random() < 0.85:
                    x, y = (places[o] + random.normal(0, 4, 2)).clip(1, 200).astype(int)
                    found[ids[o]] = (int(x), int(y), 40, 50)
            if random.random() < 0.3:
                found[90 + int(random.integers(3))] = tuple(int(n) for n in (*random.integers(1, 200, 2), 30, 30))
            frames.append(found)
        return truth, frames

    def test_pictures_outside_of_the_folder_are_refused(self):
        box = {1: (10, 10, 40, 50)}
        for number, setting in enumerate(({"imDir": "../secret"}, {"imDir": str(self.folder / "secret")},
                                          {"imDir": "img1/../.."}, {"imExt": "/../../secret/000001.png"})):
            with self.subTest(**setting):
                shutil.rmtree(self.folder / "set", ignore_errors=True)
                write_picture(self.folder / "set" / "secret" / "000001.png", [])
                self.add(f"sequence{number}", [box], [box], **setting)
                self.refused(self.evaluate(), 1, "WEIR-4002", "the name of a picture points outside the folder", "seqinfo.ini")

    def test_are_those_of_numpy(self):
        for seed in (1, 2):
            with self.subTest(seed=seed):
                self.setUp()
                truth, frames = self.random_sequence(seed)
                self.add("one", frames, truth)
                found = scores(self.evaluate("--json"))
                sequence = list(zip(truth, frames))
                mota, switches = reference.mota(sequence)
                self.assertAlmostEqual(found["MOTA"], mota, places=9)
                self.assertEqual(found["switches"], switches)
                self.assertAlmostEqual(found["IDF1"], best_idf1(sequence), places=9)
                self.assertAlmostEqual(found["HOTA"], reference.hota(sequence), places=9)
                self.assertTrue(0.1 < found["HOTA"] < 0.9 and switches > 2, found)

    def test_sequences_have_intervals(self):
        good = [{1: (10, 10, 50, 50)}] * 4
        self.add("all", good, good)
        self.add("nothing", [{}] * 4, good)
        result = json.loads(self.good(self.evaluate("--json", "--draws", 100)))
        self.assertEqual(result["unit"], "sequences")
        self.assertEqual(result["results"][0]["scores"]["MOTA"], 0.5)
        self.assertEqual(result["results"][0]["intervals"]["MOTA"], [0, 1])
        self.assertEqual(result["results"][0]["parts"]["values"], {"all": 1, "nothing": 0})

    def test_one_sequence_has_the_intervals_of_its_parts(self):
        """30 frames at 10 a second are 3 parts: two without errors and one without any box. Draws of 3 have 0 to 3 of it."""
        good = [{1: (10, 10, 50, 50)}] * 10
        self.add("one", good * 2 + [{}] * 10, good * 3)
        result = json.loads(self.good(self.evaluate("--json", "--draws", 300)))
        self.assertEqual((result["unit"], result["units"]), ("parts of one sequence", 3))
        self.assertAlmostEqual(result["results"][0]["scores"]["MOTA"], 2 / 3)
        low, high = result["results"][0]["intervals"]["MOTA"]
        self.assertTrue(-1e-9 < low <= 1 / 3 + 1e-9 and abs(high - 1) < 1e-9, (low, high))

    def test_the_interval_of_one_sequence_has_its_score(self):
        """A track that changes its number between two parts costs IDF1 in the whole and in none of the parts."""
        boxes = (10, 10, 50, 50)
        self.add("one", [{1: boxes}] * 20 + [{2: boxes}] * 20, [{1: boxes}] * 40)
        result = json.loads(self.good(self.evaluate("--json")))["results"][0]
        self.assertEqual(result["scores"]["IDF1"], 0.5)
        self.assertEqual(result["intervals"]["IDF1"], [0.5, 0.5])

    def test_a_sequence_of_less_than_two_seconds_has_no_interval(self):
        boxes = [{1: (10, 10, 50, 50)}] * 19
        self.add("one", boxes, boxes)
        result = json.loads(self.good(self.evaluate("--json")))
        self.assertEqual((result["unit"], result["results"][0]["intervals"]), ("sequences", {}))

    def test_results_without_tracks(self):
        self.add("one", [{1: (10, 10, 50, 50)}], [{1: (10, 10, 50, 50)}])
        untracked = WHOLE + 'other/tensors,weir-columns=(string)"x1,y1,x2,y2,score,class,skipped"'
        self.refused(self.evaluate(pipeline=untracked), 1, "WEIR-2001", "the results have no tracks")

    def test_a_model_alone(self):
        self.add("one", [{}], [{1: (10, 10, 50, 50)}])
        self.refused(self.evaluate(pipeline="model.onnx"), 1, "WEIR-2001", "a model alone does not track objects")

    def test_classes_that_do_not_occur(self):
        self.add("one", [{1: (10, 10, 50, 50)}], [{1: (10, 10, 50, 50)}])
        self.refused(self.evaluate("--classes", "person"), 1, "WEIR-1004", "no object has a label of --classes", "fix: --classes 0")
        self.assertEqual(scores(self.evaluate("--json", "--classes", "0"))["HOTA"], 1)

    def test_a_frame_that_is_missing_or_damaged(self):
        self.add("one", [{}] * 3, [{1: (10, 10, 50, 50)}] * 3)
        picture = self.folder / "set" / "one" / "img1" / "000002.png"
        picture.write_bytes(picture.read_bytes()[:60])
        self.refused(self.evaluate(), 1, "WEIR-4001", "a picture is damaged", "000002.png")
        picture.unlink()
        self.refused(self.evaluate(), 1, "WEIR-4001", "a picture of the sequence does not exist", "000002.png", "frames 1 to 3")

    def test_one_sequence_is_a_folder_too(self):
        boxes = [{1: (10, 10, 50, 50)}] * 2
        self.add("one", boxes, boxes)
        for folder in (self.folder / "set" / "one", f"{self.folder}/set/one/"):
            done = weir("evaluate", "--json", "--classes", "0", BOXES, folder, **WITHOUT_LEAKS)
            self.assertEqual(json.loads(self.good(done))["results"][0]["parts"]["values"], {"one": 1})

    def test_pictures_of_another_size(self):
        self.add("one", [{}], [{1: (10, 10, 50, 50)}], imWidth=640)
        self.refused(self.evaluate(), 1, "WEIR-4002", "the size of a picture differs from its size in the truth", "280 x 280", "640 x 280")


def best_idf1(sequence):
    """The pairing of tracks with most frames in common, by going through the truth's tracks one after the other (few pairs occur)."""
    truths, founds = reference.get_tracks(sequence, 0), reference.get_tracks(sequence, 1)
    common = {(a, b): sum(a in t and b in f and reference.iou(t[a], f[b]) >= 0.5 for t, f in sequence) for a in truths for b in founds}

    def best(rest, used):
        if not rest:
            return 0
        options = [best(rest[1:], used)]
        options += [common[rest[0], b] + best(rest[1:], used | {b}) for b in founds if b not in used and common[rest[0], b] > 0]
        return max(options)

    boxes = sum(len(t) + len(f) for t, f in sequence)
    return 2 * best(truths, frozenset()) / boxes


if __name__ == "__main__":
    tap_runner.main()
