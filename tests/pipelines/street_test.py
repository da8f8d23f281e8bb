#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests examples/street and benchmarks/street: the comparison on boxes made for it, what the programs refuse, and both of them on a real clip."""

import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
STREET, BENCHMARK = SOURCE / "examples/street", SOURCE / "benchmarks/street"
CONTROL = BUILD / "benchmarks/street/street-control"
CLIP = SHARED / "media/video/street_1080p25.mp4"
MODEL = SHARED / "models/detection/yolox_nano.onnx"
sys.path.insert(0, str(BENCHMARK))
import comparison  # noqa: E402


def load_bench():
    loader = importlib.machinery.SourceFileLoader("street_bench", str(BENCHMARK / "bench"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("street_bench", loader))
    loader.exec_module(module)
    return module


def frame(time, *boxes, inside=0, crossed=(0, 0)):
    return {"time": time, "detections": [{"box": box} for box in boxes],
            "zones": [{"name": "middle", "inside": inside}, {"name": "gate", "forward": crossed[0], "backward": crossed[1]}]}


class Boxes(unittest.TestCase):
    def test_overlap(self):
        """Half of each of two equal boxes is common: 1 of 3 halves."""
        self.assertEqual(comparison.overlap([0, 0, 4, 2], [2, 0, 6, 2]), 1 / 3)
        self.assertEqual(comparison.overlap([0, 0, 4, 2], [0, 0, 4, 2]), 1)
        self.assertEqual(comparison.overlap([0, 0, 4, 2], [4, 0, 8, 2]), 0)

    def test_the_best_pair_is_matched_first(self):
        """The first box overlaps both others; the second one has only one of them."""
        found, alone = comparison.pairs([[0, 0, 10, 10], [3, 0, 13, 10]], [[2, 0, 12, 10], [0, 0, 10, 10]])
        self.assertEqual(found, [1, 9 / 11])
        self.assertEqual(alone, 0)

    def test_boxes_without_a_partner_are_counted(self):
        self.assertEqual(comparison.pairs([[0, 0, 10, 10], [50, 0, 60, 10]], [[0, 0, 10, 10]]), ([1], 1))
        self.assertEqual(comparison.pairs([[0, 0, 10, 10]], [[6, 0, 16, 10]]), ([], 2))

    def test_a_whole_clip(self):
        ours = [frame(0, [0, 0, 10, 10]), frame(0.04, [0, 0, 10, 10], [50, 0, 60, 10])]
        theirs = [frame(0, [0, 0, 10, 10]), frame(0.04, [2, 0, 12, 10])]
        found = comparison.compare_boxes(ours, theirs)
        self.assertEqual((found["matched"], found["unmatched"], found["least"], found["share of 0.9"]), (2, 1, 8 / 12, 0.5))

    def test_what_cannot_be_compared(self):
        one, two = [frame(0, [0, 0, 10, 10])], [frame(0, [0, 0, 10, 10]), frame(0.04)]
        for ours, theirs, text in ((one, two, "1 frames against 2: every frame"), (one, [frame(0.04, [0, 0, 10, 10])], "0 s against 0.04 s"),
                                   (one, [frame(0, [90, 0, 99, 9])], "no boxes match")):
            with self.assertRaisesRegex(ValueError, text):
                comparison.compare_boxes(ours, theirs)

    def test_counts_of_each_frame(self):
        ours = [frame(0, inside=1), frame(0.04, inside=2), frame(0.08, inside=2), frame(0.12)]
        self.assertEqual(comparison.equal_counts(ours, [frame(0), *ours[1:]]), 0.75)
        self.assertEqual(comparison.equal_counts(ours, ours), 1)
        with self.assertRaises(ValueError):
            comparison.equal_counts(ours, ours[1:])


    def test_areas_and_lines_are_distinguished(self):
        one = frame(0, inside=3, crossed=(2, 1))
        self.assertEqual((comparison.inside(one), comparison.crossings(one)), ({"middle": 3}, {"gate": (2, 1)}))


class Bench(unittest.TestCase):
    def test_the_ratio_is_that_of_rounds_beside_each_other(self):
        """A machine that becomes slower changes both rates; the ratios of the rounds are 2, 3 and 2."""
        measured = [[{"rate": rate, "cpu": 10, "memory": 5} for rate in rates] for rates in ((20, 30, 2), (10, 10, 1))]
        text = load_bench().table({"weir": measured[0], "control": measured[1]}, ["said."])
        self.assertIn("| frames a second | 20.0 (2.0 to 30.0) | 10.0 (1.0 to 10.0) |", text)
        self.assertIn("2.00 times", text)
        self.assertIn("said.", text)

    def test_late_frames(self):
        """The display starts 5 s later than the clip; the third frame is late, the first one just in time."""
        late = load_bench().late_frames
        self.assertEqual(late([5.03, 5.04, 5.2, 5.12], [0, 0.04, 0.08, 0.12]), 1)
        self.assertEqual(late([5, 5.04], [0, 0.04]), 0)
        with self.assertRaises(ValueError):
            late([5], [0, 0.04])

    def test_what_both_found(self):
        ours = [frame(0, [0, 0, 10, 10], inside=1), frame(0.04, [0, 0, 10, 10], [90, 0, 99, 9], inside=2)]
        theirs = [frame(0, [0, 0, 10, 10], inside=1), frame(0.04, [2, 0, 12, 10], inside=1, crossed=(0, 4))]
        boxes, counts, gate = load_bench().get_verdicts(ours, theirs)
        self.assertEqual(boxes, "Boxes: 2 match and 1 are in one of both only; overlap 0.833 in the median, 50.0 % have at least 0.9, least 0.667.")
        self.assertEqual(counts, "Counts of all areas are equal in 50.0 % of the frames.")
        self.assertEqual(gate, "gate: 0 forward and 0 backward; the control has 0 and 4.")


class Refusals(unittest.TestCase):
    def refused(self, command, **env):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60, env={**os.environ, **env})
        self.assertNotEqual(done.returncode, 0)
        return done.stderr

    def test_the_script(self):
        self.assertIn("usage: ", self.refused([STREET / "street"]))
        self.assertIn("/no/clip.mp4: there is no such video", self.refused([STREET / "street", "/no/clip.mp4"]))
        text = self.refused([STREET / "street", STREET / "street"], MODEL="/no/model.onnx")
        self.assertIn("/no/model.onnx: there is no such model", text)
        self.assertIn("weir models get yolox-nano", text)

    def test_the_bench(self):
        text = self.refused([BENCHMARK / "bench", "--build", "/no/build", BENCHMARK / "bench"])
        self.assertIn("/no/build/benchmarks/street/street-control is not built", text)
        self.assertIn("apt-get install libopencv-dnn-dev libopencv-videoio-dev", text)

    @unittest.skipUnless(CONTROL.exists(), "street-control is not built")
    def test_the_control(self):
        zones = STREET / "zones.json"
        self.assertIn("MODEL.onnx ZONES.json VIDEO", self.refused([CONTROL]))
        self.assertIn("/no/zones.json", self.refused([CONTROL, MODEL, "/no/zones.json", zones]))
        self.assertIn("/no/model.onnx", self.refused([CONTROL, "/no/model.onnx", zones, zones]))

    @unittest.skipUnless(CONTROL.exists() and CLIP.exists() and MODEL.exists(), "street-control is not built, no clip or no network")
    def test_the_control_with_inputs_that_are_missing_or_too_few(self):
        command = [CONTROL, MODEL, STREET / "zones.json", CLIP]
        self.assertIn("/no/inputs: the file with the network's inputs cannot be read", self.refused(command, INPUTS="/no/inputs"))
        self.assertIn("zones.json: has no input for frame 0", self.refused(command, INPUTS=str(STREET / "zones.json")))

    def test_the_script_is_short(self):
        self.assertLessEqual(len((STREET / "street").read_text().splitlines()), 40)


@unittest.skipUnless(CLIP.exists() and MODEL.exists() and has_engine("onnxruntime"), "no clip, no network or no ONNX Runtime")
class RealClip(unittest.TestCase):
    def play(self, folder, **env):
        results = pathlib.Path(folder) / "street.jsonl"
        done = subprocess.run([STREET / "street", CLIP, results], capture_output=True, text=True, timeout=300,
                              env={**os.environ, "MODEL": str(MODEL), "SINK": "fakesink", **env})
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line) for line in results.read_text().splitlines()]

    def test_every_frame_has_people_and_counts(self):
        """Looked at: at least four people stand in each frame of the clip."""
        with tempfile.TemporaryDirectory() as folder:
            frames = self.play(folder, EVERY_FRAME="1")
        self.assertEqual(len(frames), 105)
        for one in frames:
            self.assertGreaterEqual(len(one["detections"]), 4)
            self.assertEqual({found["label"] for found in one["detections"]}, {"person"})
            seen = {"left": 0, "middle": 0, "right": 0}
            for found in one["detections"]:
                centre = (found["box"][0] + found["box"][2]) / 2
                area = "left" if centre < 640 else "middle" if centre < 1280 else "right"
                self.assertEqual([zone["name"] for zone in found["zones"]], [area])
                seen[area] += 1
            # Who is missing for less than a second is still inside.
            inside = comparison.inside(one)
            self.assertEqual(inside.keys(), seen.keys())
            self.assertTrue(all(inside[area] >= seen[area] for area in seen), (inside, seen))

    def test_skips_what_the_network_has_no_time_for(self):
        """At the rate of the clip or faster; the frames that are left are in the order of their times."""
        with tempfile.TemporaryDirectory() as folder:
            times = [one["time"] for one in self.play(folder)]
        self.assertTrue(0 < len(times) <= 105)
        self.assertEqual(times, sorted(set(times)))

    def control(self, **env):
        done = subprocess.run([CONTROL, MODEL, STREET / "zones.json", CLIP], capture_output=True, text=True, timeout=300, env={**os.environ, **env})
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    @unittest.skipUnless(CONTROL.exists(), "street-control is not built")
    def test_is_the_control_where_the_network_sees_the_same(self):
        """Every box and every count, with the tensors of the pipeline as the inputs of OpenCV's network."""
        card = SOURCE / "models/cards/yolox_nano.card.json"
        with tempfile.TemporaryDirectory() as folder:
            ours = self.play(folder, EVERY_FRAME="1")
            inputs = pathlib.Path(folder) / "inputs"
            subprocess.run(["gst-launch-1.0", "-q", "filesrc", f"location={CLIP}", "!", "decodebin", "!", "tensor_preprocess", f"card={card}", "!",
                            "filesink", f"location={inputs}"], check=True, timeout=300)
            theirs = self.control(INPUTS=str(inputs))
        found = comparison.compare_boxes(ours, theirs)
        self.assertEqual(found["unmatched"], 0)
        self.assertGreater(found["least"], 0.99)
        self.assertEqual(comparison.equal_counts(ours, theirs), 1)
        self.assertEqual([comparison.crossings(one) for one in ours], [comparison.crossings(one) for one in theirs])

    @unittest.skipUnless(CONTROL.exists(), "street-control is not built")
    def test_agrees_with_the_control(self):
        with tempfile.TemporaryDirectory() as folder:
            ours = self.play(folder, EVERY_FRAME="1")
        theirs = self.control()
        # A box that only one of both finds is inside an area for up to a second more.
        self.assertGreater(comparison.equal_counts(ours, theirs), 0.5)
        self.assertEqual(comparison.crossings(ours[-1]), comparison.crossings(theirs[-1]))
        found = comparison.compare_boxes(ours, theirs)
        self.assertGreater(found["median"], 0.95)
        self.assertGreater(found["share of 0.9"], 0.95)


if __name__ == "__main__":
    tap_runner.main()
