#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir bench`: the table, the fastest pipeline, and what is not measured."""

import json
import os
import pathlib
import pty
import re
import subprocess
import unittest

import tap_runner
from weir_case import COMMAND, HAS_ONNX, MODEL, SOURCE, Case, weir

SHORT = ("--seconds", "0.05")
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
QUANTISED = SHARED / "models/classification/mobilenet_v1_0.25_224_quant.tflite"
WITH_ITS_OWN_OPERATOR = SHARED / "models/detection/coco_ssd_mobilenet_v1_1.0_quant.tflite"
CAN_LOWER = HAS_ONNX and "tensorflow-lite" in os.environ["WEIR_MODULE_PATH"] and QUANTISED.is_file()
LUA = SOURCE / "src/modules/engines/lua/halves.lua"


class Bench(Case):
    def model(self, name="model.bin"):
        path = self.folder / name
        path.write_text("the engine looks at nothing")
        return path

    def report(self, *words):
        return json.loads(self.good(weir("bench", "--json", *SHORT, *words)))

    def refusal(self, *words):
        done = weir("bench", "--json", *SHORT, *words)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        return json.loads(done.stdout)["error"]

    def test_the_table_and_the_line(self):
        output = self.good(weir("bench", "-e", "fake", "-t", "1,2", "-b", "1,2,8", *SHORT, self.model()))
        rows = re.findall(r"^  fake +(\d+) +(\d+) +- +([\d.]+) +([\d.]+) +([\d.]+) +[\d.]+ +\d+ +[\d.]+$", output, re.M)
        self.assertEqual(sorted((t, b) for t, b, *_ in rows), sorted((t, b) for t in "12" for b in "128"))
        times = [float(row[2]) for row in rows]
        self.assertEqual(times, sorted(times), "the fastest first")
        for _, _, middle, low, high in rows:
            self.assertLessEqual(float(low), float(middle))
            self.assertLessEqual(float(middle), float(high))
        self.assertRegex(output, rf"\nCPU     .+, {len(os.sched_getaffinity(0))} cores?\n")
        fastest = re.search(r"The fastest: fake, threads (\d), batch (\d)\n  (gst-launch-1.0 .*)\n", output)
        self.assertIn(f"threads={fastest[1]}", fastest[3])
        self.assertEqual(f"batch-size={fastest[2]}" in fastest[3], fastest[2] != "1")
        self.runs(fastest[3])

    def test_json(self):
        report = self.report("-e", "fake", "-t", "1", "-b", "1,4", self.model())
        self.assertEqual(sorted(c["batch"] for c in report["cases"]), [1, 4])
        for case in report["cases"]:
            self.assertAlmostEqual(case["frames_per_second"] * case["ms"], 1000, places=3)
            self.assertGreater(case["load_ms"], 0)
            self.assertGreater(case["ms_10_percent"], 0)
            self.assertLessEqual(case["ms_10_percent"], case["ms"])
            self.assertLessEqual(case["ms"], case["ms_90_percent"])
            self.assertGreaterEqual(case["memory_mib"], 0)
        self.assertIn(report["fastest"], report["cases"])
        self.assertEqual(report["not_measured"], [])
        self.assertEqual(report["cpu"]["cores"], len(os.sched_getaffinity(0)))
        self.runs(report["launch"])

    def test_a_terminal_sees_what_is_measured_and_others_do_not(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        words = [COMMAND, "bench", "-e", "fake", "-t", "1", "-b", "1,2", *SHORT, str(self.model())]
        running = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=theirs, text=True)
        os.close(theirs)
        seen = ""
        while "] 5/6 measurements" not in seen:
            seen += os.read(ours, 1000).decode()  # raises when the process has ended
        self.assertIn("fake, threads 1, batch 2", seen)
        running.communicate(timeout=60)
        self.assertEqual(running.returncode, 0)
        self.assertEqual(weir(*words[1:]).stderr, "")

    def test_options_go_to_the_engine_and_into_the_line(self):
        report = self.report("-e", "fake", "-t", "1", "-b", "2", "--custom", "rows:2,drop-at:1", self.model())
        self.assertEqual([c["custom"] for c in report["cases"]], ["rows:2,drop-at:1"])
        self.assertIn("custom=rows:2,drop-at:1", report["launch"])
        self.assertIn("batch-size=2", report["launch"])
        self.assertTrue(any("collects" in note for note in report["notes"]))

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_engines_are_found_by_the_file(self):
        report = self.report("-t", "1", MODEL)
        self.assertEqual([(c["engine"], c["batch"]) for c in report["cases"]], [("onnxruntime", 1)])
        self.assertIn("fake", report["for_other_files"])
        refused = report["not_measured"][0]
        self.assertEqual((refused["case"], refused["error"]["id"]), ("onnxruntime, batch 4", "WEIR-3013"))
        self.assertIn("mul:0.00784313725", report["launch"])  # as in the model's card
        self.runs(report["launch"])

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_card_of_ones_own_prepares_the_line(self):
        card = json.loads((SOURCE / "models/clock_digits.card.json").read_text())
        card["inputs"][0]["mean"] = [100]
        own = self.folder / "own.card.json"
        own.write_text(json.dumps(card))
        self.assertIn("add:-100", self.report("-t", "1", "-b", "1", "--card", own, MODEL)["launch"])
        self.assertEqual(self.refusal("--card", self.folder / "none.json", MODEL)["id"], "WEIR-4001")

    def test_options_set_what_the_model_leaves_open(self):
        report = self.report("-e", "fake", "-t", "1", "-b", "1", "--input", "4:7", "--inputtype", "float32", self.model())
        self.assertIn("threads=1 input=4:7 inputtype=float32", report["launch"])
        self.assertIn("input-dim=4:7 ", report["launch"])
        self.runs(report["launch"])
        for word, code in (("x:4", "WEIR-1002"), ("0", "WEIR-1002")):
            self.assertEqual(self.refusal("-e", "fake", "-b", "1", "--input", word, self.model())["id"], code)
        self.assertEqual(self.refusal("-e", "fake", "-b", "1", "--inputtype", "float31", self.model())["id"], "WEIR-1003")

    def test_a_model_of_any_tensors_needs_them_as_options(self):
        script = SOURCE / "src/modules/engines/python3/passthrough.py"
        done = weir("bench", "--json", *SHORT, "-t", "1", "-b", "1", script)
        if "WEIR-3002" in done.stdout:
            self.skipTest("Python or NumPy is not installed")
        error = json.loads(done.stdout)["error"]
        self.assertEqual((error["id"], error["fix"]), ("WEIR-2001", "--input 3:224:224:1 --inputtype uint8"))
        report = self.report("-t", "1", "-b", "1", "--input", "3:8:8:1", "--inputtype", "uint8", script)
        self.assertEqual([c["engine"] for c in report["cases"]], ["python3"])
        self.runs(report["launch"])

    def test_a_script(self):
        done = weir("bench", "--json", *SHORT, LUA)
        if "WEIR-3002" in done.stdout:
            self.skipTest("LuaJIT is not installed")
        report = json.loads(self.good(done))
        self.assertEqual([(c["engine"], c["threads"]) for c in report["cases"]], [("lua", 1)])
        self.runs(report["launch"])

    @unittest.skipUnless(CAN_LOWER, "onnxruntime or tensorflow-lite is not built, or ../shared is not there")
    def test_a_lowered_graph_is_a_row_that_names_what_runs_it(self):
        cache = {"XDG_CACHE_HOME": str(self.folder)}
        words = ("bench", "--seconds", "0.3", "-t", "1", "-b", "1")
        output = self.good(weir(*words, QUANTISED, **cache))
        rows = re.findall(r"^  (\S+(?: \([^)]*\))?) +1 +1 +(\S+) +[\d.]+ ", output, re.M)
        self.assertEqual(set(rows), {("tensorflow-lite (lowered to onnxruntime)", "Lowering:onnxruntime"),
                                     ("onnxruntime (lowered)", "-"), ("tensorflow-lite", "-"), ("tensorflow-lite", "Delegate:None")})
        self.assertIn("lowered", rows[0][0], "the fastest, by a factor")
        fastest = re.search(r"The fastest: (.*), threads 1, batch 1(?:, Lowering:onnxruntime)?\n  (.*)\n  note: (.*)\n", output)
        self.assertIn("lowered", fastest[1])
        self.assertRegex(fastest[2], r"framework=(onnxruntime |tensorflow-lite .*custom=Lowering:onnxruntime )")
        self.assertRegex(fastest[3], "^lowered: Weir translated the graph for onnxruntime\. Its results can differ slightly")
        report = json.loads(self.good(weir(*words, "--json", "-e", "tensorflow-lite", "--custom", "Lowering:onnxruntime", QUANTISED, **cache)))
        self.assertEqual([c["lowered_to"] for c in report["cases"]], ["onnxruntime"])
        self.runs(report["launch"])

    @unittest.skipUnless(CAN_LOWER, "onnxruntime or tensorflow-lite is not built, or ../shared is not there")
    def test_a_graph_that_is_not_lowered_is_no_row_of_its_own(self):
        report = json.loads(self.good(weir("bench", "--json", "--seconds", "0.05", "-t", "1,2", WITH_ITS_OWN_OPERATOR,
                                         XDG_CACHE_HOME=str(self.folder))))
        self.assertEqual({(c["engine"], c["custom"], c["lowered_to"]) for c in report["cases"]},
                         {("tensorflow-lite", "", None), ("tensorflow-lite", "Delegate:None", None)})
        refused = {r["case"]: r["error"] for r in report["not_measured"]}
        self.assertEqual(set(refused), {"onnxruntime", "tensorflow-lite, Lowering:onnxruntime", "tensorflow-lite, batch 4"})
        self.assertIn("the operator TFLite_Detection_PostProcess", refused["onnxruntime"]["what"])
        without = refused["tensorflow-lite, Lowering:onnxruntime"]
        self.assertEqual((without["what"], without["fix"]), ("the option changes nothing for this model", "omit the option"))
        self.assertIn("TFLite_Detection_PostProcess", without["difference"])
        self.assertNotIn("onnxruntime", report["for_other_files"])

    def test_batches_that_a_model_refuses_are_reported_and_the_rest_is_measured(self):
        output = self.good(weir("bench", "-e", "fake", "-t", "1,2", "-b", "1,4", "--custom", "stateful:1", *SHORT, self.model()))
        self.assertEqual(len(re.findall(r"^  fake +\d+ +1 ", output, re.M)), 2)
        self.assertRegex(output, r"Not measured\n  fake, batch 4\n    WEIR-3013: the model keeps state")

    def test_a_model_that_fails_is_an_error(self):
        error = self.refusal("-e", "fake", "-b", "1", "--custom", "fail-at:1", self.model())
        self.assertEqual((error["id"], error["what"], error["fix"]), ("WEIR-3006", "ordered to fail", "drop the option"))

    def test_an_engine_that_ends_its_process_is_a_case_that_failed(self):
        for word, end in (("crash", "signal"), ("abort", "signal 6"), ("exit", "exit code")):
            error = self.refusal("-e", "unruly", "-t", "1", "-b", "1", "--custom", f"open:{word}", self.model())
            self.assertEqual((error["id"], error["what"]), ("WEIR-3014", "the engine terminated its process"))
            self.assertIn(end, error["offered"])

    def test_an_engine_that_hangs_is_ended(self):
        error = self.refusal("-e", "unruly", "-t", "1", "-b", "1", "--timeout", "1", "--custom", "open:loop", self.model())
        self.assertEqual((error["id"], error["fix"]), ("WEIR-3015", "weir bench --timeout 10"))

    def test_one_engine_that_fails_leaves_the_others(self):
        report = self.report("-e", "fake,onnxruntme", "-t", "1", "-b", "1", self.model())
        self.assertEqual([c["engine"] for c in report["cases"]], ["fake"])
        self.assertEqual(report["not_measured"][0]["case"], "onnxruntme")
        self.assertIn("did you mean onnxruntime?", report["not_measured"][0]["error"]["difference"])

    def test_a_folder_and_a_missing_file_are_reported_as_such(self):
        self.refused(weir("bench", self.folder), 1, "WEIR-3003: the model is a folder", f"offered: {self.folder}")
        self.refused(weir("bench", self.folder / "model"), 1, "WEIR-3003: the model file does not exist")

    def test_files_and_engines_that_are_not_there(self):
        self.assertEqual(self.refusal("-e", "fake", self.folder / "none.bin")["id"], "WEIR-3003")
        self.assertEqual(self.refusal("-e", "onnxruntme", MODEL)["id"], "WEIR-3001")
        self.assertEqual(self.refusal("")["id"], "WEIR-3003")
        unknown = self.refusal(self.model("model.zzz"))
        self.assertEqual((unknown["id"], unknown["what"]), ("WEIR-3001", "no engine can be selected for this model"))
        self.assertIn("weir bench --engine NAME", unknown["fix"])

    def test_an_engine_that_is_missing_comes_with_its_command(self):
        done = weir("bench", *SHORT, MODEL, WEIR_MODULE_PATH=str(self.folder))
        self.refused(done, 1, "WEIR-3002", "tools/setup --engine onnxruntime")

    def test_wrong_arguments_are_usage_errors(self):
        for words in ((), ("-t", "0", "m"), ("-t", "two", "m"), ("-b", "1,0", "m"), ("--seconds", "0", "m"), ("--sceonds", "1", "m")):
            self.refused(weir("bench", *words), 2)

    def test_the_process_of_a_case_is_no_command_for_people(self):
        self.assertNotIn("bench-case", weir("--help").stdout)
        self.assertIn("bench", weir("--help").stdout)


if __name__ == "__main__":
    os.environ.pop("GST_DEBUG", None)
    tap_runner.main()
