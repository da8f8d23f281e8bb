#!/usr/bin/python3
"""The command `weir` as people and programs use it."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import unittest

COMMAND = os.environ["WEIR_COMMAND"]
PLUGIN = pathlib.Path(os.environ["WEIR_PLUGIN"])
SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
DECOY = pathlib.Path(os.environ["WEIR_DECOY"])
MODEL = SOURCE / "models" / "clock_digits.onnx"
HAS_ONNX = "onnxruntime" in os.environ["WEIR_MODULE_PATH"]


def weir(*words, **environment):
    return subprocess.run([COMMAND, *map(str, words)], env={**os.environ, **environment}, cwd=SOURCE, timeout=60,
                          text=True, capture_output=True, stdin=subprocess.DEVNULL)


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def good(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def refused(self, done, code, *said):
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        for words in said:
            self.assertIn(words, done.stdout + done.stderr)


class Usage(Case):
    def test_help_names_the_subcommands(self):
        said = self.good(weir("--help"))
        for name in ("doctor", "inspect", "run"):
            self.assertIn(name, said)

    def test_version(self):
        self.assertRegex(self.good(weir("--version")), r"^weir \d+\.\d+\.\d+\n$")

    def test_wrong_words_are_usage_errors(self):
        for words in ((), ("docter",), ("inspect",), ("run",), ("doctor", "--jsn")):
            self.refused(weir(*words), 2)

    def test_manual_pages_render(self):
        for page in sorted((SOURCE / "apps/weir").glob("*.1")):
            done = subprocess.run(["groff", "-man", "-ww", "-z", page], capture_output=True, text=True)
            self.assertEqual(done.stderr, "", page.name)


class Doctor(Case):
    def test_it_tells_what_is_there(self):
        said = self.good(weir("doctor"))
        for words in ("GStreamer 1.", str(PLUGIN), "tensor_filter", "Conflicts\n  none", "Engines"):
            self.assertIn(words, said)

    def test_json(self):
        told = json.loads(self.good(weir("doctor", "--json")))
        self.assertTrue(told["usable"])
        self.assertEqual(told["plugin"]["file"], str(PLUGIN))
        self.assertIn("tensor_converter", [e["name"] for e in told["elements"]])
        states = {e["name"]: e["state"] for e in told["engines"]}
        self.assertEqual(states["fake"], "usable")
        self.assertEqual(states["bad-version"], "refused")
        self.assertEqual(states["openvino"], "not available")

    def test_missing_engines_come_with_their_command(self):
        said = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        for name in ("onnxruntime", "tensorflow-lite"):
            self.assertIn(f"{name} is not installed", said)
            self.assertIn(f"tools/setup --engine {name}", said)

    def test_a_module_that_cannot_be_used_is_named(self):
        (self.folder / "libweir-engine-onnxruntime.so").write_text("no module")
        said = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        self.assertIn("onnxruntime is refused", said)
        self.assertIn(str(self.folder / "libweir-engine-onnxruntime.so"), said)

    def test_a_missing_plugin_is_an_error_with_its_fix(self):
        done = weir("doctor", GST_PLUGIN_PATH=str(self.folder), GST_PLUGIN_SYSTEM_PATH_1_0=str(self.folder),
                    GST_REGISTRY=str(self.folder / "registry"))
        self.refused(done, 1, "not found", str(self.folder), "make install")

    def test_a_second_copy_is_a_conflict(self):
        copy = pathlib.Path(shutil.copy(PLUGIN, self.folder))
        said = self.good(weir("doctor", GST_PLUGIN_PATH=f"{PLUGIN.parent}:{self.folder}",
                              GST_REGISTRY=str(self.folder / "registry")))
        self.assertIn("another copy of Weir's plug-in", said)
        self.assertIn(str(copy), said)

    def test_another_plugin_with_the_same_elements_is_a_conflict(self):
        for folders in ((DECOY.parent, PLUGIN.parent), (PLUGIN.parent, DECOY.parent)):
            done = weir("doctor", "--json", GST_PLUGIN_PATH=":".join(map(str, folders)),
                        GST_REGISTRY=str(self.folder / f"registry-{folders[0].name}"))
            conflicts = json.loads(done.stdout)["conflicts"]
            if "decoy" in {e["plugin"] for e in json.loads(done.stdout)["elements"]}:
                self.assertEqual([(c["plugin"], c["file"]) for c in conflicts], [("decoy", str(DECOY))])
                self.assertIn("GStreamer takes tensor_filter from it, not from Weir", conflicts[0]["reason"])
                return
        self.fail("GStreamer took the decoy's element in no order: " + done.stdout)


class Inspect(Case):
    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_it_describes_the_model_in_both_orders(self):
        said = self.good(weir("inspect", MODEL))
        for words in ("1:192:32:1", "(1, 32, 192, 1)", "13:12:1", "(1, 12, 13)", "float32", "onnxruntime"):
            self.assertIn(words, said)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_json_and_the_line_it_gives_runs(self):
        told = json.loads(self.good(weir("inspect", "--json", MODEL)))
        self.assertEqual(told["inputs"][0]["shape"], [1, 32, 192, 1])
        self.assertEqual(told["inputs"][0]["dimension"], "1:192:32:1")
        self.assertEqual(told["engine"]["name"], "onnxruntime")
        self.assertIn(".onnx", told["engine"]["reason"])
        self.assertTrue(told["launch"].startswith("gst-launch-1.0 "))
        done = subprocess.run(["bash", "-c", told["launch"]], cwd=SOURCE, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, told["launch"] + done.stderr)

    def test_an_engine_by_name(self):
        model = self.folder / "model.bin"
        model.write_text("x")
        said = self.good(weir("inspect", "-f", "fake", model))
        self.assertIn("--framework fake", said)
        self.assertIn("4:?", said)

    def test_a_missing_model_is_refused_with_a_guess(self):
        self.refused(weir("inspect", "-f", "fake", SOURCE / "models" / "clock_digit.onnx"), 1, "WEIR-3003",
                     "did you mean clock_digits.onnx?")

    def test_what_is_no_model_is_refused(self):
        self.refused(weir("inspect", SOURCE / "README.md"), 1, "WEIR-3001", "no engine claims")
        self.refused(weir("inspect", ""), 1, "WEIR-3003")

    def test_a_missing_engine_is_refused_with_its_command(self):
        self.refused(weir("inspect", MODEL, WEIR_MODULE_PATH=str(self.folder)), 1, "WEIR-3002",
                     "tools/setup --engine onnxruntime")

    def test_errors_are_json_too(self):
        done = weir("inspect", "--json", MODEL, WEIR_MODULE_PATH=str(self.folder))
        error = json.loads(done.stdout)["error"]
        self.assertEqual((done.returncode, error["id"]), (1, "WEIR-3002"))
        self.assertIn("fix", error)


class Run(Case):
    PIPELINE = "videotestsrc num-buffers=7 ! tensor_converter ! tensor_sink name=out"

    def test_it_ends_with_the_ledger(self):
        done = weir("run", self.PIPELINE)
        said = self.good(done)
        self.assertRegex(said, r"Ended after [\d.]+ s: 7 frames")
        self.assertRegex(said, r"out +7 +7 +0")
        self.assertNotIn("\033", said + done.stderr)

    def test_the_pipeline_may_come_as_many_words(self):
        self.assertIn("7 frames", self.good(weir("run", *self.PIPELINE.split())))

    def test_json(self):
        told = json.loads(self.good(weir("run", "--json", self.PIPELINE)))
        self.assertEqual((told["result"], told["frames"]), ("eos", 7))
        stats = {entry["element"]: entry["stats"] for entry in told["ledger"]}
        self.assertEqual(stats["tensor_sink"]["consumed"], 7)
        self.assertEqual(stats["tensor_converter"]["pushed"], 7)

    def test_a_terminal_sees_progress(self):
        script = f"{COMMAND} run '{self.PIPELINE} sync=true'"
        done = subprocess.run(["script", "-qec", script, "/dev/null"], capture_output=True, text=True, timeout=60,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("7 frames", done.stdout)

    def test_errors_of_elements_come_with_their_fix(self):
        done = weir("run", "videotestsrc num-buffers=1 ! tensor_converter ! tensor_transform mode=typecast option=flot32 ! fakesink")
        self.refused(done, 1, "WEIR-1001", "flot32", "fix: ", "Failed after")

    def test_a_pipeline_that_cannot_be_read_is_refused(self):
        self.refused(weir("run", "videotestsrc ! ! fakesink"), 1, "the pipeline cannot be read")
        self.refused(weir("run", " "), 1, "the pipeline is empty")
        self.refused(weir("run", "videotestsrc nosuch=1 ! fakesink"), 1, "nosuch")

    def test_an_unknown_element_is_refused_with_a_guess(self):
        self.refused(weir("run", "videotestsrc ! tensor_convertr ! fakesink"), 1, 'no element "tensor_convertr"',
                     "tensor_converter in place of tensor_convertr")

    def interrupted(self, pipeline, name, *, when_it_plays):
        """The ended process: with `when_it_plays`, the signal came after 20 frames."""
        out = self.folder / "frames"
        running = subprocess.Popen([COMMAND, "run", pipeline.format(out=out)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        status = pathlib.Path(f"/proc/{running.pid}/status")
        caught = 1 << (name - 1)
        while running.poll() is None and not int(re.search(r"SigCgt:\s*(\w+)", status.read_text())[1], 16) & caught:
            pass
        while when_it_plays and running.poll() is None and not (out.exists() and out.stat().st_size > 20 * 8 * 8 * 4):
            pass
        running.send_signal(name)
        said, errors = running.communicate(timeout=30)
        self.assertEqual(running.returncode, 130, said + errors)
        self.assertIn("Interrupted after", said)
        self.assertIn("Ledger", said)
        return errors

    LIVE = ("videotestsrc is-live=true ! video/x-raw,width=8,height=8,framerate=100/1 ! tensor_converter"
            " ! filesink location={out} buffer-mode=unbuffered")

    def test_an_interrupt_waits_for_the_frames_under_way(self):
        for name in (signal.SIGINT, signal.SIGTERM):
            self.assertIn("stopping", self.interrupted(self.LIVE, name, when_it_plays=True))

    def test_an_interrupt_at_the_start_ends_it_too(self):
        for _ in range(5):
            self.interrupted(self.LIVE, signal.SIGINT, when_it_plays=False)


if __name__ == "__main__":
    unittest.main()
