#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir evaluate: its scores of boxes, key points, classes and maps against NumPy, and its progress."""

import json
import os
import re
import subprocess
import unittest

import numpy
import reference_metrics as reference
import tap_runner
from evaluation_case import BOXES, COLUMN_CAPS, LABELS, WHOLE, Coco, scores, write_picture
from PIL import Image
from weir_case import COMMAND, SANITIZED, SOURCE, WITHOUT_LEAKS, Case, weir


class AveragePrecision(Coco):
    def random_set(self, seed, pictures=20, categories=3):
        """Boxes near those of the truth, false ones, crowds, areas of all ranges."""
        random = numpy.random.default_rng(seed)
        known = []
        for _ in range(pictures):
            truths, rows = [], []
            for _ in range(random.integers(0, 5)):
                category = int(random.integers(categories))
                size = random.choice((20, 60, 140))
                x, y = random.integers(5, 250 - size, 2)
                box = [int(x), int(y), int(size + random.integers(-5, 5)), int(size + random.integers(-5, 5))]
                truths.append({"category": category, "box": box, "area": box[2] * box[3] * 0.75, "crowd": bool(random.random() < 0.15)})
                if random.random() < 0.8:
                    shift = random.integers(-size // 6, size // 6 + 1, 4)
                    edges = numpy.clip([x, y, x + box[2], y + box[3]] + shift, 1, 255)
                    rows.append([*edges, random.integers(1, 256), category if random.random() < 0.9 else random.integers(categories)])
            for _ in range(random.integers(0, 4)):
                x, y = random.integers(1, 200, 2)
                rows.append([x, y, *(numpy.array([x, y]) + random.integers(5, 55, 2)), random.integers(1, 256), random.integers(categories)])
            self.add([], [[int(n) for n in row] for row in rows])
            for t in truths:
                self.truth["annotations"].append({"id": len(self.truth["annotations"]) + 1, "image_id": len(self.truth["images"]),
                                                  "category_id": t["category"] + 1, "bbox": t["box"], "area": t["area"],
                                                  "iscrowd": int(t["crowd"])})
            known.append((truths, [(int(r[5]), float(r[4]), [int(r[0]), int(r[1]), int(r[2] - r[0]), int(r[3] - r[1])]) for r in rows]))
        self.write([f"kind {i}" for i in range(categories)])
        return known

    def test_is_that_of_numpy(self):
        for seed in (1, 2):
            with self.subTest(seed=seed):
                self.setUp()
                known = self.random_set(seed)
                found = scores(self.evaluate("--json", "--draws", 0))
                mean = lambda index=0, **how: reference.average_precision(known, 3, **how)[index]  # noqa: E731
                small, medium, large = ({"low": 0, "high": 32**2}, {"low": 32**2, "high": 96**2}, {"low": 96**2, "high": 1e10})
                expected = {"AP": mean(), "AP50": mean(thresholds=[0.5]), "AP75": mean(thresholds=[0.75]),
                            "AP small": mean(**small), "AP medium": mean(**medium), "AP large": mean(**large),
                            "AR 1": mean(1, most=1), "AR 10": mean(1, most=10), "AR 100": mean(1),
                            "AR small": mean(1, **small), "AR medium": mean(1, **medium), "AR large": mean(1, **large)}
                self.assertEqual(set(found), set(expected))
                for name, value in expected.items():
                    self.assertAlmostEqual(found[name], value, places=9, msg=name)
                self.assertTrue(0.1 < found["AP"] < 0.9, found)  # not a set where everything is right or wrong

    def test_two_runs_are_equal(self):
        self.random_set(3, pictures=6)
        self.assertEqual(self.evaluate("--json").stdout, self.evaluate("--json").stdout)

    def test_a_pipeline_does_not_differ_from_itself(self):
        self.random_set(4, pictures=6)
        done = self.evaluate("--json", "--compare", BOXES, "--draws", 50)
        difference = json.loads(self.good(done))["difference"]
        self.assertEqual(difference["AP"], {"value": 0, "interval": [0, 0]})

    def test_a_worse_pipeline_is_found_worse(self):
        for _ in range(12):
            self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.write()
        shifted = WHOLE + "tensor_transform mode=arithmetic option=per-channel:true@0,add:9@0,add:9@1,add:0@2 ! " + COLUMN_CAPS
        done = self.evaluate("--compare", shifted, "--draws", 50)
        self.assertRegex(self.good(done), r"B is worse than A: AP differs by -0\.\d+, 95 % -0\.\d+ to -0\.\d+")

    def test_the_interval_has_the_score_in_it(self):
        self.random_set(5, pictures=12)
        result = json.loads(self.good(self.evaluate("--json", "--draws", 200)))["results"][0]
        low, high = result["intervals"]["AP"]
        self.assertTrue(low < result["scores"]["AP"] < high, result["intervals"])

    def test_a_limit_takes_the_first_pictures(self):
        self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.add([(0, 10, 10, 80, 80)], [])
        self.write()
        self.assertEqual(scores(self.evaluate("--json", "--limit", 1))["AP"], 1)
        self.assertLess(scores(self.evaluate("--json"))["AP"], 0.6)

    def test_sinks_of_the_pipeline_do_not_stop_it(self):
        """More pictures than a tensor_sink keeps for a program that pulls."""
        for _ in range(70):
            self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.write()
        sinks = ("tee name=t ! queue ! videoconvert ! video/x-raw,format=GRAY8 ! tensor_converter ! tensor_sink "
                 "t. ! queue ! appsink max-buffers=1 sync=false t. ! queue ! ")
        self.assertEqual(scores(self.evaluate("--json", "--draws", 0, pipeline=sinks + BOXES))["AP"], 1)

    def test_labels_of_other_categories_are_left_out_with_a_warning(self):
        self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0], [10, 10, 90, 90, 250, 7]])
        self.write()
        done = self.evaluate()
        self.assertIn("results with labels that are not in the truth are ignored", done.stderr)
        self.assertIn("class 7 (1)", done.stderr)
        self.assertIn("assigned to thing", done.stderr)
        self.assertRegex(self.good(done), r"(?m)^AP +1\.000")


class KeyPoints(Coco):
    """Objects of one point, whose deviation is 1: OKS = exp(-d^2 / (8 area))."""

    PIPELINE = WHOLE + 'other/tensors,weir-columns=(string)"x1,y1,x2,y2,score,xy:1"'

    def add_person(self, distance, labelled=True):
        self.add([(0, 10, 10, 80, 50)], [[10, 10, 90, 60, 200, 40 + distance, 30]], area=100,
                 keypoints=[40, 30, 2] if labelled else [0, 0, 0], num_keypoints=int(labelled))

    def test_average_precision_is_that_of_the_definition(self):
        for distance in (0, 10, 15, 20):
            with self.subTest(distance=distance):
                self.setUp()
                self.add_person(distance)
                self.write()
                similarity = numpy.exp(-distance**2 / (2 * 100 * 4))
                done = self.evaluate("--json", pipeline=self.PIPELINE)
                self.assertEqual(json.loads(done.stdout)["metric"], "oks")
                self.assertAlmostEqual(scores(done)["AP"], (reference.THRESHOLDS <= similarity).mean(), places=9)
                self.assertEqual(scores(self.evaluate("--json", "--metric", "ap", pipeline=self.PIPELINE))["AP"], 1)

    def test_persons_without_points_do_not_count(self):
        self.add_person(0)
        self.add_person(100, labelled=False)
        self.write()
        self.assertEqual(scores(self.evaluate("--json", pipeline=self.PIPELINE))["AP"], 1)

    def test_another_number_of_points(self):
        self.add_person(0)
        self.write()
        without = WHOLE + 'other/tensors,weir-columns=(string)"x1,y1,x2,y2,score,skipped:2"'
        done = self.evaluate("--metric", "oks", pipeline=without)
        self.refused(done, 1, "WEIR-2001", "the results do not have the key points of the truth", "offered: 0 key points", "--metric ap")


class Classes(Case):
    def add(self, name, picture, *ranked):
        rows = [[0, 0, 0, 0, 250 - 10 * i, c] for i, c in enumerate(ranked)]
        write_picture(self.folder / "set" / name / picture, rows)

    def evaluate(self, *options):
        return weir("evaluate", LABELS, self.folder / "set", *options, **WITHOUT_LEAKS)

    def test_folders_are_classes(self):
        """Folders with numbers are class indices."""
        self.add("1", "a.png", 1, 2)
        self.add("1", "b.png", 2, 1)
        self.add("2", "a.png", 2)
        self.add("2", "b.png", 6, 5, 4, 3, 0)
        done = self.evaluate("--json")
        found = scores(done)
        self.assertEqual(found, {"top-1": 0.5, "top-5": 0.75, "mean of classes": 0.5})
        result = json.loads(done.stdout)["results"][0]
        self.assertEqual(result["confusion"], [[1, 1, 0], [0, 1, 1]])
        self.assertEqual(result["parts"]["values"], {"1": 0.5, "2": 0.5})

    def test_the_same_picture_in_two_classes(self):
        self.add("1", "a.png", 1)
        self.add("2", "b.png", 1)
        done = self.evaluate()
        self.refused(done, 1, "WEIR-4002", "the same picture is in two classes", "1/a.png and", "2/b.png",
                     "fix: delete one of the two files")

    def test_a_class_without_pictures_is_a_warning(self):
        self.add("1", "a.png", 1)
        (self.folder / "set" / "2").mkdir()
        done = self.evaluate()
        self.good(done)
        self.assertIn("the folder of a class has no pictures", done.stderr)

    def test_labels_that_are_no_class(self):
        self.add("cat", "a.png", 5)
        done = self.evaluate()
        self.refused(done, 1, "WEIR-4002", "none of the labels in the results is a category of the truth", "offered: class 5",
                     "needed:", "cat", "fix: --labels FILE")

    def test_a_page_has_the_confusion(self):
        self.add("1", "a.png", 2)
        self.add("2", "b.png", 2, 1)
        page = self.folder / "page.html"
        done = self.evaluate("--page", page)
        self.good(done)
        self.assertIn('<b class="bad">1</b>', page.read_text())
        self.assertIn("1, found: 2 ", page.read_text())


class Maps(Case):
    """Pictures are class maps themselves: tensor_converter makes one of a grey picture."""

    PIPELINE = ('videoconvert ! video/x-raw,format=GRAY8 ! tensor_converter ! tensor_transform mode=dimchg option=0:2 ! '
                'other/tensors,weir-columns=(string)class-map')

    def add(self, name, found, truth, palette=None):
        for folder, pixels in (("images", found), ("masks", truth)):
            (self.folder / "set" / folder).mkdir(parents=True, exist_ok=True)
            picture = Image.fromarray(numpy.array(pixels, numpy.uint8))
            if palette and folder == "masks":
                picture = picture.convert("P")
                picture.putpalette(palette)
                picture.putdata(numpy.array(pixels).reshape(-1).tolist())
            picture.save(self.folder / "set" / folder / f"{name}.png")

    def evaluate(self, *options):
        return weir("evaluate", self.PIPELINE, self.folder / "set", *options, **WITHOUT_LEAKS)

    def random_maps(self):
        random = numpy.random.default_rng(1)
        truth = numpy.kron(random.integers(0, 4, (6, 8)), numpy.ones((4, 4), int))
        found = numpy.where(random.random(truth.shape) < 0.8, truth, random.integers(0, 4, truth.shape))
        truth[:3] = 255
        return found, truth

    def check(self, palette=None):
        found, truth = self.random_maps()
        self.add("one", found, truth, palette)
        counted = truth != 255
        overlaps = [(counted & (truth == c) & (found == c)).sum() / (counted & ((truth == c) | (found == c))).sum() for c in range(4)]
        result = json.loads(self.good(self.evaluate("--json")))["results"][0]
        self.assertAlmostEqual(result["scores"]["mean IoU"], numpy.mean(overlaps), places=12)
        self.assertAlmostEqual(result["scores"]["pixel accuracy"], (truth == found)[counted].mean(), places=12)
        for c in range(4):
            self.assertAlmostEqual(result["parts"]["values"][f"class {c}"], overlaps[c], places=12)

    def test_grey_masks(self):
        self.check()

    def test_masks_with_a_palette(self):
        self.check([channel for i in range(256) for channel in (i * 7 % 256, 255 - i, i * 3 % 256)])

    def test_pictures_and_masks_without_each_other(self):
        self.add("one", [[0, 1] * 8] * 8, [[0, 1] * 8] * 8)
        (self.folder / "set" / "images" / "two.png").write_bytes((self.folder / "set" / "images" / "one.png").read_bytes())
        (self.folder / "set" / "masks" / "three.png").write_bytes((self.folder / "set" / "masks" / "one.png").read_bytes())
        done = self.evaluate()
        self.assertRegex(self.good(done), r"(?m)^mean IoU +1\.000")
        self.assertIn("pictures without a mask are left out", done.stderr)
        self.assertIn("images/two.png", done.stderr)
        self.assertIn("masks without a picture are left out", done.stderr)
        self.assertIn("masks/three.png", done.stderr)

    def test_masks_that_do_not_fit(self):
        self.add("one", [[0, 1] * 8] * 8, [[0, 1] * 4] * 8)
        self.refused(self.evaluate(), 1, "a mask does not have the size of its picture", "no picture of the folder can be used")
        Image.new("RGB", (16, 8)).save(self.folder / "set" / "masks" / "one.png")
        self.refused(self.evaluate(), 1, "the mask is not a PNG file with a class for each pixel")

    def test_a_detector_has_no_class_map(self):
        write_picture(self.folder / "set" / "images" / "one.png", [])
        write_picture(self.folder / "set" / "masks" / "one.png", [])
        done = weir("evaluate", BOXES, self.folder / "set", **WITHOUT_LEAKS)
        self.refused(done, 1, "WEIR-2001", "the results have no class map")


@unittest.skipIf(SANITIZED, "script(1) runs the command with other libraries")
class Progress(Coco):
    def test_a_terminal_shows_a_bar(self):
        for _ in range(3):
            self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.write()
        import pty
        master, terminal = pty.openpty()
        done = subprocess.run([COMMAND, "evaluate", BOXES, str(self.folder / "set")], stdout=subprocess.PIPE, stderr=terminal,
                              stdin=subprocess.DEVNULL, cwd=SOURCE, timeout=60, text=True)
        os.close(terminal)
        shown = os.read(master, 1 << 16).decode()
        os.close(master)
        self.assertEqual(done.returncode, 0, shown)
        self.assertRegex(shown, r"\r\033\[K\[#* +\] \d/3 pictures")
        self.assertRegex(shown, r"\r\033\[K\[#* *\] \d+/1000 draws for the intervals")
        self.assertNotRegex(done.stdout, "[\r\033]")


if __name__ == "__main__":
    tap_runner.main()
