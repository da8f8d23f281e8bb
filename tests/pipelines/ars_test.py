#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests examples/ars: its lines, networks, converter and control, and what they do with bad input."""

import hashlib
import importlib.util
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

import numpy

import ars_reference as reference
import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
ARS, BENCHMARK = SOURCE / "examples/ars", SOURCE / "benchmarks/ars"
MODULES, NETWORKS = BUILD / "examples/ars", ARS / "networks"
HAS_PACKAGE = (BUILD / "bindings/python/weir/__init__.py").exists()
sys.path[:0] = [str(BUILD / "bindings/python"), str(ARS), str(BENCHMARK / "measure")]
import code_lines  # noqa: E402
import event_camera  # noqa: E402
import lines  # noqa: E402
import radio  # noqa: E402
import simulator  # noqa: E402
import table  # noqa: E402

FILTER = f"tensor_filter framework=custom model={MODULES}/libars-"
ENVIRONMENT = {**os.environ, "WEIR_MODULE_PATH": f"{MODULES}:{os.environ['WEIR_MODULE_PATH']}",
               "PYTHONPATH": f"{BUILD}/bindings/python:{os.environ['PYTHONPATH']}", "GST_TRACERS": "", "GST_DEBUG": ""}


def call(command, **more):
    return subprocess.run([str(word) for word in command], env=ENVIRONMENT, capture_output=True, timeout=120, check=False, **more)


def launch(line):
    return call(["gst-launch-1.0", "-q", *shlex.split(line)])


def activities_of(done):
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.decode().split("\0")[:-1]


# Sinks are async=false where an error is expected: gst-launch-1.0 may wait for ever when one comes while it prerolls.
class WithRecording(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.recording = cls.folder / "recording"
        done = call([ARS / "simulate", "--seconds", 20, cls.recording])
        assert done.returncode == 0, done.stderr
        cls.frames = numpy.fromfile(cls.recording / "events.frames", numpy.uint8).reshape(-1, 48, 64)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()


class Lines(WithRecording):
    def readme_lines(self):
        blocks = re.findall(r"```sh\n(gst-launch-1.0.*?)\n```", (ARS / "README.md").read_text(), re.DOTALL)
        return [" ".join(block.replace("\\\n", " ").split()) for block in blocks]

    def test_the_readme_has_the_lines_of_the_programs(self):
        sink = "filesink location=/dev/stdout"
        self.assertEqual(sorted(self.readme_lines()), sorted(
            "gst-launch-1.0 -q " + lines.filled(line, "recording/events.es" if name == "a-recorded" else "recording", "build", sink, "examples/ars")
            for name, line in lines.LINES.items()))

    def test_each_line_of_the_readme_gives_as_many_results_as_there_are_windows(self):
        # 600 event frames, of which the Event Stream file completes 599, and 500 responses.
        windows = (600 - 8) // 4 + 1
        expected = {"libars-vote": windows - 5, "libars-sequence": (windows - 12) // 3 + 1, "tensor_merge": (500 - 75) // 25 + 1}
        for line in self.readme_lines():
            if "onnxruntime" in line and not has_engine("onnxruntime"):
                print("skipped, for the engine onnxruntime is not here", file=sys.stderr)
                continue
            with self.subTest(line=line):
                done = launch(line.removeprefix("gst-launch-1.0 -q ").replace("build/", f"{BUILD}/").replace("recording/", f"{self.recording}/")
                              .replace("examples/ars/networks", str(NETWORKS)).replace("examples/ars/activities", f"{ARS}/activities"))
                found = activities_of(done)
                kind = next(word for word in ("tensor_merge", "libars-sequence", "libars-vote") if word in line)
                self.assertEqual(len(found), expected[kind] - ("event-stream" in line), line)
                self.assertLessEqual(set(found), set(simulator.ACTIVITIES))

    def test_run_plays_and_shows_the_line(self):
        command = [ARS / "run", "--build", BUILD]
        played = call([*command, "b", self.recording])
        shown = call([*command, "--show", "b", self.recording])
        self.assertEqual(played.stdout.decode().split("\n")[:-1], activities_of(call(shlex.split(shown.stdout.decode()))))
        missing = call([*command, "a", self.folder / "nowhere"])
        self.assertEqual((missing.returncode, missing.stdout), (1, b""))
        self.assertIn("there is no such recording\n  fix: examples/ars/simulate", missing.stderr.decode())

    @unittest.skipUnless(HAS_PACKAGE, "the package weir for Python is not built")
    def test_control_and_program_agree_with_the_pipelines(self):
        line = {name: activities_of(launch(lines.filled(lines.LINES[name], self.recording, BUILD, "filesink location=/dev/stdout")))
                for name in ("a", "b", *(["c", "bc"] if has_engine("onnxruntime") else []))}
        for name, expected in line.items():
            for workers in (1, 2):
                done = call([BENCHMARK / "control.py", "--modules", MODULES, "--networks", NETWORKS, "--workers", workers, name, self.recording])
                self.assertEqual(activities_of(done), expected, name)
                played = call([ARS / "run", "--build", BUILD, "--workers", workers, name, self.recording])
                self.assertEqual(played.stdout.decode().split("\n")[:-1], expected, name)
        done = call([ARS / "from_python", "--build", BUILD, self.recording])
        self.assertEqual(done.stdout.decode().split("\n")[:-1], line["a"], done.stderr)


class Networks(WithRecording):
    def test_weights_are_those_of_their_cards(self):
        for name in ("event_network.f32", "sequence_network.f16", "radio_network.onnx"):
            weights = NETWORKS / name
            card = json.loads(weights.with_suffix(".card.json").read_text())
            self.assertEqual(card["sha256"], hashlib.sha256(weights.read_bytes()).hexdigest(), name)
            self.assertEqual(card["labels"], list(simulator.ACTIVITIES))

    def test_filters_compute_what_numpy_computes(self):
        windows = numpy.stack([self.frames[begin:begin + 8] for begin in range(0, 592, 37)])
        inputs = (windows.astype(numpy.float32) - 128) / 16
        results = self.filtered("event-network", "event_network.f32", inputs, "64:48:8")
        expected = [reference.event_network(NETWORKS / "event_network.f32", one) for one in inputs]
        numpy.testing.assert_allclose(results, expected, atol=1e-4)
        sequences = numpy.stack([results[begin:begin + 12] for begin in range(3)])
        expected = [reference.sequence_network(NETWORKS / "sequence_network.f16", one) for one in sequences]
        numpy.testing.assert_allclose(self.filtered("sequence-network", "sequence_network.f16", sequences, "5:12"), expected, atol=1e-4)

    def filtered(self, name, weights, inputs, dimensions):
        (self.folder / "in").write_bytes(inputs.astype("<f4").tobytes())
        done = launch(f"filesrc location={self.folder}/in blocksize={inputs[0].size * 4} ! application/octet-stream ! tensor_converter "
                      f"input-dim={dimensions} input-type=float32 ! {FILTER}{name}.so custom=weights:{NETWORKS}/{weights} ! "
                      f"filesink location={self.folder}/out")
        self.assertEqual(done.returncode, 0, done.stderr)
        return numpy.fromfile(self.folder / "out", "<f4").reshape(-1, 5)

    def test_the_vote_is_the_mean_of_all_rows(self):
        rows = numpy.array([[1, 0, 0, 0, 0], [0, 0.5, 0.5, 0, 0], [0, 0, 1, 0, 0]], "<f4")
        (self.folder / "rows").write_bytes(rows.tobytes())
        source = f"filesrc location={self.folder}/rows blocksize=60 ! application/octet-stream ! tensor_converter input-dim=5:3 input-type=float32"
        for line in (f"{source} ! {FILTER}vote.so ! filesink location={self.folder}/mean",
                     f"{source} ! tee name=t t. ! queue ! mux.sink_0 t. ! queue ! mux.sink_1 tensor_mux name=mux sync-mode=nosync ! "
                     f"{FILTER}vote.so custom=inputs:2 ! filesink location={self.folder}/mean"):
            self.assertEqual(launch(line).returncode, 0, line)
            numpy.testing.assert_allclose(numpy.fromfile(self.folder / "mean", "<f4"), [1 / 3, 1 / 6, 0.5, 0, 0], atol=1e-6)

    @unittest.skipUnless(HAS_PACKAGE, "the package weir for Python is not built")
    def test_held_back_clips_are_recognised_as_the_cards_say(self):
        """25 of the 150 clips of each card: the share may differ from the card's by what so few clips allow."""
        import weir

        event = weir.Model(MODULES / "libars-event-network.so", engine="custom", options={"weights": str(NETWORKS / "event_network.f32")})
        sequence = weir.Model(MODULES / "libars-sequence-network.so", engine="custom", options={"weights": str(NETWORKS / "sequence_network.f16")})
        right = {"event_network": [], "sequence_network": []}
        for index in range(25):
            frames = (event_camera.clip(simulator.ACTIVITIES[index % 5], simulator.generator(7, index)).astype(numpy.float32) - 128) / 16
            results = [event.invoke(frames[begin:begin + 8])[0].ravel() for begin in range(0, 113, 4)]
            right["event_network"] += [one.argmax() == index % 5 for one in results]
            right["sequence_network"] += [sequence.invoke(numpy.stack(results[begin:begin + 12]))[0].argmax() == index % 5
                                          for begin in range(0, len(results) - 11, 3)]
        if has_engine("onnxruntime"):
            of_radio = weir.Model(NETWORKS / "radio_network.onnx", threads=1)
            right["radio_network"] = []
            for index in range(25):
                responses = radio.clip(simulator.ACTIVITIES[index % 5], simulator.generator(7, index))
                for window in (responses[:, :75], responses[:, 25:]):
                    window = numpy.abs(window - window.mean((1, 2), keepdims=True)) / window.std((1, 2), keepdims=True)
                    right["radio_network"].append(of_radio.invoke(window[None].astype(numpy.float32))[0].argmax() == index % 5)
        for name, found in right.items():
            provenance = json.loads((NETWORKS / f"{name}.card.json").read_text())["provenance"]
            self.assertAlmostEqual(numpy.mean(found), provenance["accuracy_held_back"], delta=0.12, msg=name)
            self.assertGreater(numpy.mean(found), 0.6, name)


@unittest.skipUnless(importlib.util.find_spec("torch"), "no PyTorch")
class Training(unittest.TestCase):
    def test_weights_are_written_as_the_filters_read_them(self):
        """Networks with random weights: PyTorch's own results against those from the files."""
        sys.path.insert(0, str(SOURCE / "tools/train"))
        import activity_networks as networks
        import torch

        torch.manual_seed(3)
        event, sequence = networks.EventNetwork(5), networks.SequenceNetwork(5).eval()
        event(torch.randn(16, 8, 48, 64) + 1)  # statistics of the batch normalisations
        event.eval()
        frames, results = torch.randn(8, 48, 64), torch.rand(12, 5)
        with tempfile.TemporaryDirectory() as folder, torch.no_grad():
            for network, export, compute, window in (
                    (event, networks.export_event_network, reference.event_network, frames),
                    (sequence, networks.export_sequence_network, reference.sequence_network, results)):
                weights = pathlib.Path(folder) / "weights.f32"
                export(network, weights)
                expected = networks.Probabilities(network)(window[None])[0].numpy()
                numpy.testing.assert_allclose(compute(weights, window.numpy()), expected, atol=1e-5)

    def test_standardised_is_what_the_pipeline_makes(self):
        """The absolute value, with a mean of 0 and a deviation of 1 before: docs/compatibility/transform.md 3.6."""
        sys.path.insert(0, str(SOURCE / "tools/train"))
        import train_activities

        values = numpy.array([[[1.0, 3.0], [5.0, 7.0]]])
        numpy.testing.assert_allclose(train_activities.standardised(values), numpy.abs((values - 4) / numpy.sqrt(5)))


class EventStream(WithRecording):
    def converted(self, data, rate=30, blocksize=64):
        (self.folder / "in.es").write_bytes(data)
        done = launch(f"filesrc location={self.folder}/in.es blocksize={blocksize} ! application/x-event-stream,framerate={rate}/1 ! "
                      f"tensor_converter ! filesink async=false location={self.folder}/out.frames")
        return done, numpy.fromfile(self.folder / "out.frames", numpy.uint8).reshape(-1, 48, 64)

    def refused(self, data, *words, **more):
        done, _ = self.converted(data, **more)
        self.assertNotEqual(done.returncode, 0, done.stdout)
        for word in words:
            self.assertIn(word, done.stderr.decode())
        self.assertNotIn("CRITICAL", done.stderr.decode())

    def test_frames_are_those_of_the_simulator(self):
        done, frames = self.converted((self.recording / "events.es").read_bytes())
        self.assertEqual(done.returncode, 0, done.stderr)
        numpy.testing.assert_array_equal(frames, self.frames[:-1])

    def test_a_recording_that_ends_in_an_event_or_a_frame_gives_its_whole_frames(self):
        data = (self.recording / "events.es").read_bytes()
        for length in (len(data) // 2, len(data) // 2 + 1, len(data) // 2 + 3, 21):
            done, frames = self.converted(data[:length])
            self.assertEqual(done.returncode, 0, done.stderr)
            numpy.testing.assert_array_equal(frames, reference.event_frames(data[:length], 30).reshape(-1, 48, 64))

    @unittest.skipUnless((SHARED / "media/sensor/dvs.es").exists(), "no recording of a camera")
    def test_a_recording_of_a_camera(self):
        data = (SHARED / "media/sensor/dvs.es").read_bytes()
        done, frames = self.converted(data)
        self.assertEqual(done.returncode, 0, done.stderr)
        numpy.testing.assert_array_equal(frames, reference.event_frames(data, 30))
        self.assertEqual(len(frames), 29)
        played = call([ARS / "run", "--build", BUILD, "a-recorded", SHARED / "media/sensor/dvs.es"])
        self.assertEqual(played.returncode, 0, played.stderr)
        self.assertEqual(len(played.stdout.decode().split("\n")[:-1]), (29 - 8) // 4 + 1 - 5)

    def test_other_bytes_are_refused(self):
        header = b"Event Stream\x02\x00\x00\x01" + (64).to_bytes(2, "little") + (48).to_bytes(2, "little")
        self.refused(b"RIFF" + header[4:] + bytes(99), "the bytes are not an event stream", "needed: a file of Event Stream 2.0 with DVS events")
        self.refused(header[:15] + b"\x02" + header[16:] + bytes(99), "the bytes are not an event stream")
        self.refused(header[:16] + bytes([100, 0, 48, 0]) + bytes(99), "offered: 100x48", "needed: multiples of 64x48")
        self.refused(header + bytes([3, 64, 0, 1, 0]), "an event lies outside the camera's picture", "offered: 64,1", "needed: less than 64,48")
        self.refused(header, "an event stream has no frame rate", "fix: application/x-event-stream,framerate=30/1", rate=0)

    def test_buffers_of_many_frames_are_refused(self):
        header = b"Event Stream\x02\x00\x00\x01" + (64).to_bytes(2, "little") + (48).to_bytes(2, "little")
        quiet = header + b"\xff" * 80000 + bytes([1, 0, 0, 0, 0])  # 10.2 s
        self.refused(quiet, "hold too many frames each", "fix: filesrc blocksize=64", blocksize=100000)


class BadInput(WithRecording):
    def refused(self, line, *words):
        done = launch(line)
        text = done.stderr.decode()
        self.assertNotEqual(done.returncode, 0, line + text)
        for word in words:
            self.assertIn(word, text)
        self.assertNotIn("CRITICAL", text)

    def test_weights(self):
        source = "filesrc location=/dev/zero blocksize=98304 num-buffers=1 ! application/octet-stream ! tensor_converter input-dim=64:48:8 input-type=float32"
        network = f"{source} ! {FILTER}event-network.so"
        self.refused(f"{network} ! fakesink async=false", "the filter has no weights", "fix: custom=weights:PATH")
        self.refused(f"{network} custom=weights:/nowhere ! fakesink async=false", "the weights cannot be read", "offered: /nowhere")
        size = (NETWORKS / "event_network.f32").stat().st_size
        self.refused(f"{network} custom=weights:{NETWORKS}/sequence_network.f16 ! fakesink async=false", "the weights are not those of this network",
                     f"needed: {size // 4} finite float32 numbers, {size} bytes")
        broken = bytearray((NETWORKS / "event_network.f32").read_bytes())
        broken[400:404] = numpy.array([numpy.nan], "<f4").tobytes()
        (self.folder / "nan.f32").write_bytes(broken)
        self.refused(f"{network} custom=weights:{self.folder}/nan.f32 ! fakesink async=false", "finite float32 numbers")
        whole = (NETWORKS / "sequence_network.f16").read_bytes()
        source = "filesrc location=/dev/zero blocksize=240 num-buffers=1 ! application/octet-stream ! tensor_converter input-dim=5:12 input-type=float32"
        for name, data in (("nan", whole[:400] + b"\x01\x7c" + whole[402:]), ("infinite", whole[:400] + b"\x00\xfc" + whole[402:]), ("short", whole[:-2])):
            (self.folder / f"{name}.f16").write_bytes(data)
            self.refused(f"{source} ! {FILTER}sequence-network.so custom=weights:{self.folder}/{name}.f16 ! fakesink async=false",
                         "the weights are not those of this network", f"needed: {len(whole) // 2} finite float16 numbers, {len(whole)} bytes")

    def test_votes(self):
        source = "filesrc location=/dev/zero blocksize=16 num-buffers=1 ! application/octet-stream ! tensor_converter input-dim=4 input-type=float32"
        self.refused(f"{source} ! {FILTER}vote.so ! fakesink async=false", "the vote's input is not rows of results", "innermost dimension 5")
        for number in ("0", "17"):
            self.refused(f"{source} ! {FILTER}vote.so custom=inputs:{number} ! fakesink async=false", "number of inputs is not usable", f"offered: {number}")
        for text in ("two", "2x"):
            self.refused(f"{source} ! {FILTER}vote.so custom=inputs:{text} ! fakesink async=false", f"offered: custom=inputs:{text}", "needed: an integer")

    def test_a_recording_of_frames_that_ends_in_a_frame(self):
        short = self.folder / "short"
        short.mkdir()
        (short / "events.frames").write_bytes(self.frames.tobytes()[:3072 * 100 + 82])
        done = launch(lines.filled(lines.LINES["a"], short, BUILD, "filesink async=false location=/dev/stdout"))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-2004: a buffer does not hold whole frames\n  offered: 82 bytes\n  needed: a multiple of 3072 bytes", done.stderr.decode())

    @unittest.skipUnless(has_engine("onnxruntime"), "the engine onnxruntime is not here")
    def test_a_radio_that_ends_early_ends_the_stream(self):
        short = self.folder / "radios"
        short.mkdir()
        for number, responses in ((0, 500), (1, 200)):
            (short / f"radio{number}.frames").write_bytes((self.recording / f"radio{number}.frames").read_bytes()[:128 * responses])
        found = activities_of(launch(lines.filled(lines.LINES["c"], short, BUILD, "filesink location=/dev/stdout")))
        self.assertEqual(len(found), (200 - 75) // 25 + 1)

    @unittest.skipUnless(HAS_PACKAGE and has_engine("onnxruntime"), "no package weir, or no engine onnxruntime")
    def test_a_radio_that_stops_is_replaced_by_its_last_window_after_max_wait(self):
        import weir

        window = "tensor_aggregator frames-out=75 frames-flush=25 frames-dim=1 ! queue"
        line = (f"appsrc name=one ! {window} ! merge.sink_0 appsrc name=other ! {window} ! merge.sink_1 "
                f"{lines.RADIO_NETWORK.replace('sync-mode', 'max-wait=100000000 sync-mode')} ! tensor_sink name=results")
        with weir.Pipeline(lines.filled(line, self.recording, BUILD, "")) as pipeline:
            response = numpy.ones((1, 32), numpy.float32)
            for number in range(200):
                for name in ("one", *(["other"] if number < 100 else [])):
                    pipeline.push(name, response, pts=number * 40_000_000, duration=40_000_000)
            # 6 windows of one radio; the other one's second is used for the rest.
            self.assertEqual([pipeline.pull("results", timeout=30).pts for _ in range(6)], [number * 1_000_000_000 for number in range(6)])

    @unittest.skipUnless(HAS_PACKAGE, "the package weir for Python is not built")
    def test_times_that_go_back(self):
        import weir

        for choice, passed in (("pass", 4), ("drop", 3)):
            line = f"appsrc name=frames ! tensor_aggregator name=windows frames-out=8 frames-flush=4 frames-dim=2 on-backwards-time={choice} ! tensor_sink name=out"
            with weir.Pipeline(line) as pipeline:
                for number in range(20):
                    time = number - 10 if 12 <= number < 15 else number
                    pipeline.push("frames", self.frames[number][None], pts=time * 33_000_000, duration=33_000_000)
                pipeline.end("frames")
                count = 0
                while pipeline.pull("out", timeout=30) is not None:
                    count += 1
                stats = pipeline.get("windows", "stats").replace("\\", "")
                self.assertIn(f"dropped-time=(guint64){3 if choice == 'drop' else 0},", stats)
                self.assertIn("backwards-times=(guint64)1;" if choice == "pass" else "backwards-times=(guint64)3;", stats)
            self.assertEqual(count, passed, choice)


class Bench(unittest.TestCase):
    def test_table(self):
        row, cpu, memory, live = "output rate, frames per second", "rate per CPU, frames per CPU second", "resident memory, MB", "CPU share at the sensor's rate, %"
        both = "output rate with 2 workers, frames per second"
        results = {"a": {"weir": [{row: value, cpu: 4.0, both: 60.0, memory: 40.0, live: 1.0} for value in (10.0, 30.0, 20.0)],
                         "control": [{row: 5.0, cpu: 2.0, both: 10.0, memory: 65.0, live: 4.0}], "bare": [{row: 25.0, cpu: 5.0, memory: 5.0}]},
                   "b": {"weir": [{row: 80.0, cpu: 9.0, both: 60.0, memory: 40.0, live: 1.0}],
                         "control": [{row: 20.0, cpu: 2.0, both: 40.0, memory: 65.0, live: 2.0}], "bare": [{row: 80.0, cpu: 10.0, memory: 5.0}]}}
        text = table.markdown(results, {"a": (10, 50), "b": (12, 48)}, {"a": 4, "b": 12}, 2)
        self.assertIn("| A: output rate, frames per second | 20 (10 to 30) | 5 | 25 | 80 % | 4.00 |", text.splitlines())
        self.assertIn("| B: lines of code | 12 | 48 | - | - | 0.25 |", text.splitlines())
        # Ratios 20/5 = 4, 80/20 = 4; 4/2 = 2, 9/2 = 4.5; 60/5 = 12, 60/20 = 3; 35 MB over 60 MB above the bare engine's 5.
        for row in ("output rate at least 1.66 times the control's, geometric mean | 4.00 (A 4.00, B 4.00)",
                    "rate per CPU at least 1.75 times the control's, geometric mean | 3.00 (A 2.00, B 4.50)",
                    "the same, with 2 workers in both programs | 3.00 (A 6.00, B 1.50)",
                    "the same, with 2 workers in Weir (a property) and one thread in the control | 6.00 (A 12.00, B 3.00)",
                    "output rate at least 95 % of the bare engine's | A 80 %, B 100 %", "the same by CPU time | A 80 %, B 90 %",
                    "resident memory above the bare engine's at most 0.7 times the control's | A 0.58, B 0.58",
                    "CPU at the sensor's rate at most 0.5 times the control's | A 0.25, B 0.50"):
            self.assertIn(f"| {row} |", text.splitlines())
        # 4 frames at 5, 4 and 2 frames per CPU second are 0.8, 1 and 2 CPU seconds.
        self.assertIn("| A | 800.000 | 200.000 | 1200.000 | 2.50 |", text.splitlines())

    @unittest.skipUnless(HAS_PACKAGE, "the package weir for Python is not built")
    def test_a_small_run_has_the_rows_of_the_paper(self):
        with tempfile.TemporaryDirectory() as folder:
            done = call([BENCHMARK / "bench", "--build", BUILD, "--rounds", 1, "--variants", "b", "--live-seconds", 6, "--output", folder])
            self.assertEqual(done.returncode, 0, done.stderr)
            text = (pathlib.Path(folder) / "ars.md").read_text()
        rows = [line.split(" | ")[0].removeprefix("| B: ") for line in text.splitlines() if line.startswith("| B: ")]
        self.assertEqual(rows, ["lines of code", "output rate, frames per second", "CPU share, %", "rate per CPU, frames per CPU second",
                                "mapped memory, MB", "resident memory, MB", "threads", "output rate with 2 workers, frames per second",
                                "rate per CPU with 2 workers, frames per CPU second", "CPU share at the sensor's rate, %"])
        self.assertIn("geometric mean", text)

    def test_the_bench_refuses(self):
        for arguments, words in (("--rounds 0", "at least 1 round"), ("--live-seconds 5", "6 to 44 seconds"), ("--variants a,z", "no variant z: a, b, c, bc"), ("--workers 1", "at least 2 workers"),
                                 ("--build /nowhere", "no benchmarks/ars/ars-bare: make build")):
            done = call([BENCHMARK / "bench", "--build", BUILD, *arguments.split()])
            self.assertEqual(done.returncode, 2, arguments)
            self.assertIn(words, done.stderr.decode())

    def test_lines_of_code(self):
        self.assertEqual(code_lines.lines_with_code('"""Doc."""\n\n# no\na = 1  # yes\nb = """x\ny"""\n'), {4, 5, 6})
        self.assertEqual(code_lines.of_pipeline("filesrc location=a ! application/octet-stream ! tensor_converter name=c ! mux.sink_0 tensor_mux name=mux ! fakesink"), 5)


if __name__ == "__main__":
    tap_runner.main()
