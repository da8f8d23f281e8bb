#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests benchmarks/mtcnn/bench: its arithmetic on hand-made values, its table, its clips, and a small run."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
VIDEO = SHARED / "media/video/street_1080p25.mp4"
NETWORKS = SHARED / "models/face/mtcnn"
BENCHMARK = SOURCE / "benchmarks/mtcnn"
sys.path.insert(0, str(BENCHMARK / "measure"))
import lines  # noqa: E402
import numbers_of as numbers  # noqa: E402
import parts  # noqa: E402
import processes  # noqa: E402
import table  # noqa: E402


class Arithmetic(unittest.TestCase):
    def test_middle(self):
        self.assertEqual(numbers.middle([3, 1, 10]), (3, 1, 10))
        self.assertEqual(numbers.middle([1, 2, 4, 100]), (3, 1, 100))

    def test_percentile_is_a_value_that_was_seen(self):
        hundred = list(range(1, 101))
        self.assertEqual([numbers.percentile(hundred, share) for share in (0.01, 0.5, 0.99, 1)], [1, 50, 99, 100])
        self.assertEqual(numbers.percentile([7, 5, 6], 0.99), 7)
        self.assertEqual(numbers.percentile([7, 5, 6], 0.5), 6)
        for values, share in (([], 0.5), ([1], 0), ([1], 1.1)):
            with self.assertRaises(ValueError):
                numbers.percentile(values, share)

    def test_rate_counts_distances(self):
        self.assertEqual(numbers.rate([10.0, 10.5, 11.0]), 2)
        self.assertEqual(numbers.rate([11.0, 10.0, 10.5]), 2)
        for times in ([], [1.0], [1.0, 1.0]):
            with self.assertRaises(ValueError):
                numbers.rate(times)

    def test_jitter(self):
        self.assertEqual([round(one, 6) for one in numbers.jitter_ms([0, 0.5, 0.75, 1.5], 0.5)], [0, 250, 250])

    def test_slope_after_warming_up(self):
        """100 MB within the first second, then 2 MB a second: 120 a minute."""
        samples = [(5 + t / 10, 100 * min(t / 10, 1) + 2 * t / 10) for t in range(100)]
        self.assertAlmostEqual(numbers.slope_per_minute(samples, 1), 120)
        self.assertGreater(numbers.slope_per_minute(samples, 0), 200)
        self.assertEqual(numbers.slope_per_minute([(0, 5), (1, 5), (2, 5)], 0), 0)
        with self.assertRaises(ValueError):
            numbers.slope_per_minute(samples, 9.8)

    def test_percentage_of_the_floor(self):
        self.assertEqual(numbers.of_floor(15, 20), 75)
        self.assertIsNone(numbers.of_floor(15, None))
        self.assertIsNone(numbers.of_floor(15, 0))

    def test_latencies_of_all_rounds(self):
        rounds = [{"pictures": [[1, 2, 3, 6], [2, 3, 4, 9], [9, 9, 9, 27]]}, {"pictures": [[4, 4, 4, 12]]}]
        each, once, count = parts.of_latencies(rounds)
        self.assertEqual([one["latency, ms"] for one in each], [9, 12])
        self.assertEqual(each[0]["regions and R-Net, ms"], 3)
        self.assertEqual((once, count), ({"latency, slowest, ms": 27}, 4))

    def test_a_hundred_pictures_have_a_slowest_hundredth(self):
        of = {count: [{"pictures": [[0, 0, 0, n] for n in range(1, count + 1)]}] for count in (99, 100)}
        self.assertEqual(parts.of_latencies(of[99])[1:], ({"latency, slowest, ms": 99}, 99))
        self.assertEqual(parts.of_latencies(of[100])[1:], ({"latency, p99, ms": 99}, 100))


class Table(unittest.TestCase):
    RESULTS = {"machine": "a machine", "clip": "a clip",
               "fast": {"weir": [{"pictures per second": 18.0}, {"pictures per second": 20.0}, {"pictures per second": 19.0}],
                        "control": [{"pictures per second": 10.0}, {"pictures per second": 9.0}, {"pictures per second": 9.5}]},
               "floor": {"onnxruntime": [{"pictures per second": rate, "pictures": [[2, 3, 4, 9]]} for rate in (30.0, 38.0, 40.0)]}}

    def test_medians_spread_and_shares(self):
        self.assertIn("| pictures per second | 19 (18 to 20); 50 % | 9.5 (9 to 10); 25 % | 38 | 2.00 |",
                      table.markdown(self.RESULTS).splitlines())

    def test_a_floor_that_decodes_is_a_row_of_its_own(self):
        label = parts.DECODES["pictures per second"]
        self.assertNotIn(label, table.markdown(self.RESULTS))
        floor = {"onnxruntime": [{**one, label: one["pictures per second"] / 2} for one in self.RESULTS["floor"]["onnxruntime"]]}
        found = table.markdown({**self.RESULTS, "floor": floor}).splitlines()
        rows = {line.split(" | ")[0]: line for line in found}
        bare, decoding = rows["| pictures per second"].split(" | "), rows["| " + label].split(" | ")
        share = [int(re.search(r"; (\d+) %", cell).group(1)) for cell in (bare[1], decoding[1])]
        self.assertAlmostEqual(share[1], 2 * share[0], delta=1)
        self.assertEqual(bare[1].split(";")[0], decoding[1].split(";")[0])

    def test_without_a_floor_no_percentage(self):
        text = table.markdown({name: value for name, value in self.RESULTS.items() if name != "floor"})
        self.assertIn("| pictures per second | 19 (18 to 20) | 9.5 (9 to 10) | 2.00 |", text.splitlines())

    def test_each_program_against_the_floor_of_its_engine(self):
        fast = {**self.RESULTS["fast"], "kernels": [{"pictures per second": 39.0}]}
        floor = {**self.RESULTS["floor"], "mtcnn-kernels": [{"pictures per second": 52.0, "pictures": [[1, 1, 1, 3]]}]}
        latency = {"kernels": [{"pictures": [[2, 2, 2, 6]]}]}
        found = table.markdown({**self.RESULTS, "fast": fast, "floor": floor, "latency": latency}).splitlines()
        self.assertEqual(found[0].split(" | ")[4:6], ["floor", "floor of own kernels"])
        self.assertIn("| pictures per second | 19 (18 to 20); 50 % | 39; 75 % | 9.5 (9 to 10); 25 % | 38 | 52 | 2.00 | 4.11 |", found)
        self.assertIn("| latency, ms | - | 6; 200 % | - | 9 | 3 | - | - |", found)

    def test_who_was_not_measured(self):
        results = {**self.RESULTS, "live": {"weir": [{"display: pictures per second": 29.5}]}}
        self.assertIn("| display: pictures per second | 29.5 | - | - | - |", table.markdown(results).splitlines())

    def test_each_of_ours_against_each_of_the_others(self):
        fast = {**self.RESULTS["fast"], "kernels": [{"pictures per second": 38.0}], "ros": [{"pictures per second": 19.0}]}
        head, _, row = table.markdown({**self.RESULTS, "fast": fast}).splitlines()[:3]
        self.assertEqual(head.split(" | ")[6:], ["Weir / control", "Weir, own kernels / control", "Weir / three ROS nodes",
                                                 "Weir, own kernels / three ROS nodes |"])
        self.assertEqual(row.split(" | ")[6:], ["2.00", "4.00", "1.00", "2.00 |"])


class Lines(unittest.TestCase):
    def test_code_counts_and_comments_do_not(self):
        self.assertEqual(lines.of_text("// one\n\nint a;  // two\n/* three\n four */\nint b;\n", ".cpp"), 2)
        self.assertEqual(lines.of_text("# one\nHeader header  # two\n", ".msg"), 1)
        self.assertEqual(lines.of_text("<launch>\n<!-- one\ntwo -->\n</launch>\n", ".launch"), 2)

    def test_every_source_of_the_programs_counts_once(self):
        counted = [name for names, _ in lines.PARTS.values() for name in names.split()]
        self.assertEqual(len(counted), len(set(counted)))
        sources = {str(f.relative_to(folder)) for folder in (lines.EXAMPLE, BENCHMARK) for pattern in ("*.[ch]pp", "*.msg", "*.launch")
                   for f in folder.rglob(pattern)}
        others = {f for f in sources if f.endswith("_test.cpp") or f.startswith("floor")}
        self.assertEqual(sources - set(counted), others)


class Processes(unittest.TestCase):
    def test_the_watchers_memory_is_not_the_programs(self):
        """A child starts as a copy of this process, and the system keeps that copy's peak memory."""
        own = bytearray(os.urandom(1 << 20) * 150)
        with tempfile.TemporaryDirectory() as folder:
            program = shutil.copy(shutil.which("sleep"), pathlib.Path(folder) / "mtcnn-sleep")
            seen = processes.watch([program, "0.5"])
        self.assertGreater(seen.peak_rss, 0)
        self.assertLess(seen.peak_rss, len(own) / (1 << 20) / 2)


@unittest.skipUnless(VIDEO.exists(), "no clip")
class Clips(unittest.TestCase):
    def test_clips_have_the_requested_length_and_rate(self):
        import clips  # needs python3-gi

        with tempfile.TemporaryDirectory() as folder:
            clip = clips.Clip(VIDEO)
            self.assertEqual(len(clip), 105)
            for count in (210, 120):  # 120: ends within reordered pictures
                again = clips.Clip(clip.again(pathlib.Path(folder) / "again.mkv", 30, count))
                self.assertEqual(len(again), count)
                times = sorted(one.get_buffer().pts / 1e9 for one in again.coded)
                for earlier, later in zip(times, times[1:]):
                    self.assertAlmostEqual(later - earlier, 1 / 30, delta=0.0011, msg=f"{count}: {earlier}")
            single = clips.Clip(clip.pictures(pathlib.Path(folder) / "single.mkv", 3, 4))
            times = [one.get_buffer().pts for one in single.coded]
            self.assertEqual([time - times[0] for time in times], [place * clips.SECOND for place in range(4)])


@unittest.skipUnless(NETWORKS.is_dir(), "no networks")
class KernelsFloor(unittest.TestCase):
    def floor(self, models, asked, *options):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "requests"
            file.write_text(asked)
            return subprocess.run([BENCHMARK / "run", "--build", BUILD, "--kernels-floor", "--models", models, *options, file],
                                  capture_output=True, text=True, timeout=300)

    def test_repeats_what_was_requested(self):
        """More regions take longer, and a picture without any runs only P-Net; takes the minimum of ten runs to exclude load."""
        done = self.floor(NETWORKS, "640 360 400 200\n640 360 2 1\n640 360 0 0\n" * 10, "--threads", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
        self.assertEqual(len(found["pictures"]), 30)
        many, few, none = ([min(column) for column in zip(*found["pictures"][kind::3])] for kind in range(3))
        for network in (1, 2):
            self.assertGreater(many[network], few[network])
            self.assertGreater(few[network], none[network])
        self.assertGreater(none[0], 0)
        for picture in found["pictures"]:
            self.assertAlmostEqual(sum(picture[:3]), picture[3], delta=0.01)
        self.assertGreater(found["rate"], 0)
        self.assertGreater(found["cpu_ms"], 0)

    @unittest.skipUnless(VIDEO.exists(), "no clip")
    def test_decodes_as_well(self):
        """With decoding, each picture costs more than in the plain loop."""
        done = self.floor(NETWORKS, "1920 1080 4 1\n" * 20, "--min-face", "300", "--clip", VIDEO)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
        self.assertGreater(found["decoding"]["cpu_ms"], found["cpu_ms"])
        self.assertGreater(found["decoding"]["rate"], 0)

    def test_refusals(self):
        for clip in (SOURCE / "README.md", SOURCE / "nowhere.mp4"):
            done = self.floor(NETWORKS, "640 360 1 1\n", "--clip", clip)
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn(f"{clip} cannot be decoded", done.stderr)
        for models, asked, words in ((NETWORKS, "", "is empty"), (SOURCE, "640 360 1 1\n", "onnx/pnet.onnx cannot be read")):
            done = self.floor(models, asked)
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn(words, done.stderr)


@unittest.skipUnless(VIDEO.exists() and (BUILD / "benchmarks/mtcnn/mtcnn-floor").exists(), "no clip, or no control is built")
class Run(unittest.TestCase):
    def bench(self, *arguments):
        return subprocess.run([BENCHMARK / "bench", "--build", BUILD, *map(str, arguments)], capture_output=True, text=True, timeout=300)

    def test_a_small_run_and_one_more_round(self):
        with tempfile.TemporaryDirectory() as folder:
            few = ("--output", folder, "--rounds", 1, "--pictures", 6, "--latency-pictures", 2, "--min-face", 300, VIDEO)
            done = self.bench("--only", "fast,latency,floor", *few)
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            done = self.bench("--only", "floor", "--more", *few)
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            results = json.loads((pathlib.Path(folder) / "mtcnn.json").read_text())
            self.assertEqual({engine: len(rounds) for engine, rounds in results["floor"].items()}, {"onnxruntime": 2, "mtcnn-kernels": 2})
            for rounds in results["floor"].values():
                self.assertEqual([len(picture) for picture in rounds[0]["pictures"]], [4] * 6)
                for stages in rounds[0]["pictures"]:
                    self.assertGreater(stages[0], 0)
                    self.assertAlmostEqual(sum(stages[:3]), stages[3], delta=0.01)
                self.assertGreater(rounds[0]["pictures per second"], 0)
            for who in ("weir", "control"):
                self.assertEqual(len(results["fast"][who]), 1)
                self.assertEqual([len(picture) for picture in results["latency"][who][0]["pictures"]], [4])
                for stages in results["latency"][who][0]["pictures"]:
                    self.assertAlmostEqual(sum(stages[:3]), stages[3], places=2)
            self.assertEqual((pathlib.Path(folder) / "mtcnn.md").read_text().strip(), done.stdout.strip())

    def test_refusals(self):
        for arguments, words in ((("--only", "speed", VIDEO), "no part speed: fast, latency, live, memory, floor"),
                                 (("--rounds", 0, VIDEO), "at least 1 round"),
                                 ((SOURCE / "nowhere.mp4",), "nowhere.mp4: no such file"),
                                 (("--output", tempfile.gettempdir(), SOURCE / "README.md"), "README.md")):
            done = self.bench(*arguments)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(words, done.stderr)
            self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
