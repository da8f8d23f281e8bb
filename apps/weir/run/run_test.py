#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir run`: the final ledger, errors with their place, interrupts."""

import json
import os
import pathlib
import pty
import re
import signal
import subprocess

import tap_runner
from weir_case import COMMAND, Case, weir


class Run(Case):
    PIPELINE = "videotestsrc num-buffers=7 ! tensor_converter ! tensor_sink name=out"

    def test_it_ends_with_the_ledger(self):
        done = weir("run", self.PIPELINE)
        output = self.good(done)
        self.assertRegex(output, r"Ended after [\d.]+ s: 7 frames")
        self.assertRegex(output, r"out +7 +7 +0")
        self.assertNotIn("\033", output + done.stderr)

    def test_the_pipeline_may_be_many_arguments(self):
        self.assertIn("7 frames", self.good(weir("run", *self.PIPELINE.split())))

    def test_json(self):
        report = json.loads(self.good(weir("run", "--json", self.PIPELINE)))
        self.assertEqual((report["result"], report["frames"]), ("eos", 7))
        stats = {entry["element"]: entry["stats"] for entry in report["ledger"]}
        self.assertEqual(stats["tensor_sink"]["consumed"], 7)
        self.assertEqual(stats["tensor_converter"]["pushed"], 7)

    def test_the_frame_rate_is_that_of_the_frames_after_the_first(self):
        report = json.loads(self.good(weir("run", "--json", self.PIPELINE + " sync=true")))
        self.assertGreater(report["seconds"], 0)
        self.assertAlmostEqual(report["frame_rate"] * report["seconds"], 6, places=6)

    def test_each_sink_is_counted(self):
        pipeline = ("videotestsrc num-buffers=5 ! tee name=t t. ! queue ! fakesink name=a t. ! queue"
                    " ! tensor_converter frames-per-tensor=5 ! tensor_sink name=b")
        output = self.good(weir("run", pipeline))
        for words in ("6 frames", "  a: 5 frames", "  b: 1 frames"):
            self.assertIn(words, output)
        sinks = json.loads(self.good(weir("run", "--json", pipeline)))["sinks"]
        self.assertEqual(sorted((s["name"], s["frames"]) for s in sinks), [("a", 5), ("b", 1)])

    def test_no_ledger_without_elements_of_weir(self):
        self.assertNotIn("Ledger", self.good(weir("run", "videotestsrc num-buffers=2 ! fakesink")))

    def test_a_terminal_sees_progress_and_others_do_not(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        running = subprocess.Popen([COMMAND, "run", self.LIVE.format(out="/dev/null")], stdout=subprocess.PIPE,
                                   stderr=theirs, text=True)
        os.close(theirs)
        seen = ""
        while not re.search(r"\r\033\[K[\d.]+ s  \d+ frames  [\d.]+ frames/s\r", seen):
            seen += os.read(ours, 1000).decode()  # raises when the process has ended
        running.send_signal(signal.SIGINT)
        output, _ = running.communicate(timeout=30)
        self.assertEqual(running.returncode, 130)
        self.assertNotIn("\033", output)
        self.assertEqual(weir("run", self.PIPELINE).stderr, "")

    def test_errors_of_elements_come_with_their_fix(self):
        done = weir("run", "videotestsrc num-buffers=1 ! tensor_converter ! tensor_transform mode=typecast option=flot32 ! fakesink")
        self.refused(done, 1, "WEIR-1001", "flot32", "fix: ", "Failed after")

    def test_the_ledger_shows_transforms_that_share_a_pass(self):
        line = "videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8 ! tensor_converter ! tensor_transform name=first mode=typecast option=float32"
        output = self.good(weir("run", f"{line} ! tensor_transform name=last mode=arithmetic option=mul:2 ! fakesink"))
        self.assertRegex(output, r"why +in one pass\n")
        self.assertRegex(output, r"\n +first .* 3 deferred to the next element\n")
        self.assertRegex(output, r"\n +last .* 3 fused\n")
        self.assertNotIn("in one pass", self.good(weir("run", f"{line} ! fakesink")))

    def test_an_error_that_is_posted_again_is_reported_once(self):
        done = weir("run", "videotestsrc num-buffers=1 ! video/x-raw,format=NV12 ! tensor_converter name=c ! fakesink")
        self.refused(done, 1, "error from c: WEIR-2002: this video format cannot be a tensor")
        self.assertEqual(done.stderr.count("error from c: "), 1, done.stderr)

    def test_errors_of_elements_are_json_too(self):
        done = weir("run", "--json", "videotestsrc num-buffers=1 ! tensor_converter"
                    " ! tensor_transform name=cast mode=typecast option=flot32 ! fakesink")
        report = json.loads(done.stdout)
        self.assertEqual((done.returncode, report["result"]), (1, "error"))
        ours = [e for e in report["errors"] if e.get("id") == "WEIR-1001"]
        self.assertEqual(ours[0]["element"], "cast")
        self.assertIn("flot32", ours[0]["offered"])

    def test_errors_of_other_elements_come_with_their_details(self):
        done = weir("run", "videotestsrc ! identity name=weak error-after=2 ! fakesink")
        self.refused(done, 1, "error from weak: ", "details: ", "Failed after")

    def place(self, *words):
        """The output for a pipeline, and the pipeline's text from the caret on."""
        done = weir("run", *words)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        text, caret = re.search(r"\n    (.*)\n    ( *)\^", done.stderr).groups()
        if not text.startswith("... "):
            self.assertIn(f"at character {len(caret) + 1}:\n", done.stderr)
        return done.stderr, text[len(caret):]

    def test_a_pipeline_that_cannot_be_read_is_refused_with_its_place(self):
        output, rest = self.place('videotestsrc ! queue name="a b" ! ! fakesink')
        self.assertIn("WEIR-1001: the pipeline cannot be read", output)
        self.assertIn("needed: elements with ! between them", output)
        self.assertEqual(rest, "! fakesink")
        self.assertEqual(self.place("! fakesink")[1], "! fakesink")
        self.assertEqual(self.place("fakesrc", "!", "!", "fakesink")[1], "! fakesink")
        self.assertEqual(self.place("videotestsrc name=ü\n ! queue !")[1], "!")

    def test_an_empty_pipeline_is_refused(self):
        self.refused(weir("run", " "), 1, "the pipeline is empty", "fix: weir run")

    def test_a_pipeline_that_cannot_be_read_is_refused_in_json_too(self):
        done = weir("run", "--json", "videotestsrc ! ! fakesink")
        error = json.loads(done.stdout)["error"]
        self.assertEqual((done.returncode, error["id"], done.stderr), (1, "WEIR-1001", ""))
        self.assertIn("syntax error at character 16", error["difference"])

    def test_unknown_properties_and_values_are_refused_with_their_place(self):
        output, rest = self.place("videotestsrc ! fakesink nosuch=1")
        self.assertEqual(rest, "nosuch=1")
        self.assertIn("fix: gst-inspect-1.0 fakesink", output)
        self.assertEqual(self.place("fakesrc ! queue leaky=maybe ! fakesink")[1], "leaky=maybe ! fakesink")

    def test_an_unknown_property_value_is_reported_with_the_known_ones(self):
        line = "videotestsrc ! video/x-raw,format=RGB ! tensor_preprocess name=p width=8 height=8 "
        output, rest = self.place(line + "layout=NHCW ! fakesink")
        self.assertEqual(rest, "layout=NHCW ! fakesink")
        for words in ("WEIR-1004: tensor_preprocess does not accept this value for layout", "offered: layout=NHCW",
                      "needed: one of: auto, NHWC, NCHW\n", "did you mean NHWC? at character",
                      "fix: gst-inspect-1.0 tensor_preprocess\n"):
            self.assertIn(words, output)
        # Another element has a property of this name, and the value is quoted.
        output, rest = self.place('audiotestsrc ! audio/x-raw,layout=interleaved ! fakesink ' + line + 'layout = "NH WC" ! fakesink')
        self.assertEqual(rest, 'layout = "NH WC" ! fakesink')
        self.assertIn("offered: layout=NH WC\n", output)
        output, rest = self.place(*line.split(), "fit=leterbox", "!", "fakesink")
        self.assertEqual(rest, "fit=leterbox ! fakesink")
        self.assertIn("did you mean letterbox?", output)
        self.good(weir("run", line.replace("videotestsrc", "videotestsrc num-buffers=1") + "layout=NCHW fit=letterbox ! fakesink"))

    def test_an_unknown_property_comes_with_the_nearest_one(self):
        output, rest = self.place("videotestsrc ! tensor_converter ! tensor_transform mode=typecast optoin=int8 ! fakesink")
        self.assertEqual(rest, "optoin=int8 ! fakesink")
        for words in ("WEIR-1004: tensor_transform has no such property", "offered: optoin\n", "did you mean option?"):
            self.assertIn(words, output)

    def test_what_cannot_be_linked_is_refused(self):
        done = weir("run", "videotestsrc ! audio/x-raw ! fakesink")
        self.refused(done, 1, "offered: videotestsrc ! audio", "can't handle caps")
        self.assertNotIn("fix:", done.stderr, "no element makes audio of this source")

    def test_what_cannot_be_linked_comes_with_the_element_that_converts_it(self):
        later = "queue name=q ! tensor_converter ! fakesink videotestsrc num-buffers=2 ! video/x-raw,format=NV12 "
        output = weir("run", later + "! q.")
        self.refused(output, 1, "q can't handle caps video/x-raw, format=(string)NV12",
                     "fix: videoconvert ! videoscale between these caps and q")
        self.assertEqual(weir("run", later + "! videoconvert ! videoscale ! q.").returncode, 0)
        output = weir("run", "queue name=q ! audio/x-raw,format=U8,rate=8000 ! fakesink audiotestsrc ! audio/x-raw,format=S16LE ! q.")
        self.refused(output, 1, "fix: audioconvert ! audioresample between these caps and q")

    def test_an_unknown_element_is_refused_with_its_place_and_a_guess(self):
        output, rest = self.place("videotestsrc ! tensor_convertr ! fakesink")
        self.assertEqual(rest, "tensor_convertr ! fakesink")
        for words in ('no element "tensor_convertr"', "fix: tensor_converter in place of tensor_convertr"):
            self.assertIn(words, output)

    LIVE = ("videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=8,height=8,framerate=100/1 ! tensor_converter"
            " ! filesink location={out} buffer-mode=unbuffered")
    FRAME = 8 * 8  # bytes

    def start(self, pipeline, *options):
        self.out = self.folder / "frames"
        self.out.unlink(missing_ok=True)
        return subprocess.Popen([COMMAND, "run", *options, pipeline.format(out=self.out)], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def wait_until_signals_are_caught(self, running):
        caught = 1 << (signal.SIGTERM - 1)  # caught after SIGINT
        while running.poll() is None:
            status = pathlib.Path(f"/proc/{running.pid}/status").read_text()
            if int(re.search(r"SigCgt:\s*(\w+)", status)[1], 16) & caught:
                return

    def wait_for_frames(self, running):
        """Waits for 20 frames: the first arrives just before the pipeline counts as playing."""
        while running.poll() is None and not (self.out.exists() and self.out.stat().st_size > 20 * self.FRAME):
            pass

    def interrupted(self, running):
        output, errors = running.communicate(timeout=30)
        self.assertEqual(running.returncode, 130, output + errors)
        return output, errors

    def test_an_interrupt_waits_for_the_frames_under_way(self):
        for name in (signal.SIGINT, signal.SIGTERM):
            running = self.start(self.LIVE)
            self.wait_for_frames(running)
            running.send_signal(name)
            output, errors = self.interrupted(running)
            self.assertIn("Interrupted after", output)
            self.assertRegex(output, r"Ledger\n +element +received +consumed")
            self.assertIn("stopping: waiting for frames in flight", errors)

    def test_after_an_interrupt_every_frame_is_accounted_for(self):
        running = self.start(self.LIVE, "--json")
        self.wait_for_frames(running)
        running.send_signal(signal.SIGINT)
        report = json.loads(self.interrupted(running)[0])
        self.assertEqual((report["result"], report["errors"]), ("interrupted", []))
        self.assertEqual(self.out.stat().st_size, report["frames"] * self.FRAME)
        stats = report["ledger"][0]["stats"]
        self.assertEqual((stats["received"], stats["pushed"], stats["held"]), (report["frames"], report["frames"], 0))

    def test_an_interrupt_at_the_start_ends_it_too(self):
        for _ in range(5):
            running = self.start(self.LIVE)
            self.wait_until_signals_are_caught(running)
            running.send_signal(signal.SIGINT)
            self.assertIn("Interrupted after", self.interrupted(running)[0])

    def test_a_second_interrupt_stops_what_does_not_end(self):
        # The valve blocks EOS for one sink.
        branch = "tee name=t t. ! queue ! valve drop=true ! fakesink async=false t. ! queue"
        running = self.start(self.LIVE.replace("tensor_converter", f"tensor_converter ! {branch}"))
        self.wait_for_frames(running)
        running.send_signal(signal.SIGINT)
        self.assertIn("interrupt again to stop at once", running.stderr.readline())
        running.send_signal(signal.SIGINT)
        output, _ = self.interrupted(running)
        self.assertIn("Ledger", output)


if __name__ == "__main__":
    tap_runner.main()
