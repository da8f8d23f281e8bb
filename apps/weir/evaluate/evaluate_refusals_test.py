#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir evaluate: folders, truth and pipelines that it refuses or warns about."""

import json

import tap_runner
from evaluation_case import BOXES, LABELS, Coco, scores, write_picture
from weir_case import weir


class Refused(Coco):
    def good_set(self):
        self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.write()

    def test_folders_that_do_not_exist_or_are_empty(self):
        self.refused(self.evaluate(), 1, "WEIR-4001", "the labelled folder does not exist")
        (self.folder / "set").mkdir()
        self.refused(self.evaluate(), 1, "WEIR-4001", "the labelled folder is empty", "seqinfo.ini, gt/gt.txt")
        (self.folder / "set" / "notes.txt").write_text("no truth")
        self.refused(self.evaluate(), 1, "WEIR-4001", "no truth in a known layout")
        self.refused(weir("evaluate", BOXES, self.folder / "set" / "notes.txt"), 1, "this is a file, not a folder")

    def test_errors_as_json(self):
        done = self.evaluate("--json")
        self.assertEqual(json.loads(done.stdout)["error"]["id"], "WEIR-4001")
        self.assertEqual(done.stderr, "")

    def test_truth_that_contradicts_itself(self):
        self.good_set()
        self.truth["annotations"][1]["image_id"] = 77
        self.write()
        self.refused(self.evaluate(), 1, "WEIR-4002", "truth.json: annotations[1], id 2, image_id 77")

    def test_several_annotation_files(self):
        self.good_set()
        (self.folder / "set" / "other.json").write_text("{}")
        self.refused(self.evaluate(), 1, "WEIR-1004", "several annotation files", "fix: --truth")
        self.assertEqual(scores(self.evaluate("--json", "--truth", self.folder / "set" / "truth.json"))["AP"], 1)

    def test_a_model_card_is_no_annotation_file(self):
        self.good_set()
        (self.folder / "set" / "model.card.json").write_text("{}")
        self.assertEqual(scores(self.evaluate("--json"))["AP"], 1)

    def test_pictures_without_truth_and_truth_without_pictures(self):
        self.good_set()
        (self.folder / "set" / "2.png").rename(self.folder / "set" / "3.png")
        done = self.evaluate()
        self.assertRegex(self.good(done), r"ap of 1 picture,")
        self.assertIn("annotations without a picture are ignored", done.stderr)
        self.assertIn("truth.json: 2.png", done.stderr)
        self.assertIn("pictures without annotations are ignored", done.stderr)
        self.assertIn("3.png", done.stderr)

    def test_a_damaged_picture_is_left_out(self):
        self.good_set()
        picture = self.folder / "set" / "2.png"
        picture.write_bytes(picture.read_bytes()[:100])
        done = self.evaluate()
        self.assertRegex(self.good(done), r"ap of 1 picture,")
        self.assertIn("a picture is damaged or has an unknown format", done.stderr)
        self.assertIn("set/2.png", done.stderr)
        (self.folder / "set" / "1.png").write_text("no picture")
        self.refused(self.evaluate(), 1, "WEIR-4002", "no picture of the folder can be used")

    def test_a_picture_of_another_size_is_left_out(self):
        self.good_set()
        write_picture(self.folder / "set" / "2.png", [], (140, 280))
        done = self.evaluate()
        self.assertRegex(self.good(done), r"ap of 1 picture,")
        self.assertIn("the size of a picture differs from its size in the truth", done.stderr)
        self.assertIn("2.png: 140 x 280 pixels", done.stderr)

    def test_names_that_lead_out_of_the_folder(self):
        for name in ("../secret.png", "/etc/secret.png"):
            self.setUp()
            self.good_set()
            self.truth["images"][0]["file_name"] = name
            self.write()
            self.refused(self.evaluate(), 1, "WEIR-4002", "the name of a picture points outside the folder", name)

    def test_results_of_another_kind(self):
        self.good_set()
        self.refused(self.evaluate(pipeline=LABELS), 1, "WEIR-2001", "the results have no boxes", "--mode detection")

    def test_metrics_without_truth(self):
        self.good_set()
        self.refused(self.evaluate("--metric", "oks"), 1, "WEIR-1004", "the folder has no truth for this metric", "--metric ap")
        self.refused(self.evaluate("--metric", "good"), 2)

    def test_pipelines_that_cannot_be_played(self):
        self.good_set()
        self.refused(self.evaluate(pipeline="videoconvert ! tensor_nonsense"), 1, "WEIR-1001", "not installed", "tensor_nonsense")
        self.refused(self.evaluate(pipeline="videoconvert ! identity"), 1, "WEIR-")

    def test_pipelines_that_lose_or_repeat_pictures(self):
        self.good_set()
        self.refused(self.evaluate(pipeline="identity drop-probability=1 ! " + BOXES), 1, "WEIR-2001",
                     "pictures have no results", "set/1.png and 1 more")
        self.refused(self.evaluate(pipeline="identity error-after=2 ! " + BOXES), 1, "identity0: ")

    def test_words_that_are_missing(self):
        self.refused(weir("evaluate"), 2)
        self.refused(weir("evaluate", BOXES), 2)
        self.good_set()
        self.refused(self.evaluate("--limit", "0"), 2)
        self.refused(self.evaluate("--draws", "-1"), 2)


if __name__ == "__main__":
    tap_runner.main()
