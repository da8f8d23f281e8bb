#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of the tracer `weir`: the output of GST_TRACERS=weir against the ledger of the same run."""

import collections
import json
import os
import subprocess
import unittest
import wave

import tap_runner
from weir_case import SANITIZED, SOURCE, Case, weir

BRANCHES = ("videotestsrc num-buffers=20 ! video/x-raw,format=RGB,width=16,height=8,framerate=30/1 ! tee name=t"
            " t. ! queue name=first ! tensor_converter name=converter ! tensor_sink name=tensors"
            " t. ! queue name=second ! fakesink name=pictures")


class Trace(Case):
    def traced(self, pipeline, options="", code=0):
        """The output of `weir run --json`, and the events of the trace."""
        file = self.folder / "trace.json"
        done = weir("run", "--json", pipeline, GST_TRACERS=f"weir(file={file}{options})")
        self.assertEqual(done.returncode, code, done.stderr)
        document = json.loads(file.read_text())
        self.assertEqual(document["displayTimeUnit"], "ms")
        return json.loads(done.stdout), document["traceEvents"]

    def pushes(self, events, category="push"):
        """Maps each element to the pushes that arrived at it."""
        found = collections.defaultdict(list)
        for event in events:
            if event["ph"] == "X" and event["cat"] == category:
                found[event["name"]].append(event)
        return found

    def test_every_frame_of_the_ledger_is_in_the_trace(self):
        report, events = self.traced(BRANCHES)
        pushes = self.pushes(events)
        for entry in report["ledger"]:
            self.assertEqual(len(pushes[entry["name"]]), entry["stats"]["received"])
        self.assertEqual({sink["name"]: sink["frames"] for sink in report["sinks"]},
                         {name: len(pushes[name]) for name in ("tensors", "pictures")})
        for push in pushes["converter"]:
            self.assertEqual((push["args"]["from"], push["args"]["bytes"], push["args"]["frames"]),
                             ("first.src", 16 * 8 * 3, 1))
        self.assertEqual([push["args"]["time_stamp_ns"] for push in pushes["tensors"]],
                         [n * 10**9 // 30 for n in range(20)])

    def test_spans_of_a_thread_nest(self):
        _, events = self.traced(BRANCHES)
        threads = collections.defaultdict(list)
        for event in events:
            if event["ph"] == "X":
                threads[event["tid"]].append((round(event["ts"] * 1000), round((event["ts"] + event["dur"]) * 1000)))
        self.assertGreaterEqual(len(threads), 4)  # the application, the source, two queues
        for spans in threads.values():
            open_ends = []
            for begin, end in sorted(spans, key=lambda span: (span[0], -span[1])):
                while open_ends and open_ends[-1] <= begin:
                    open_ends.pop()
                if open_ends:
                    self.assertLessEqual(end, open_ends[-1])
                open_ends.append(end)

    def test_threads_queues_states_and_events_are_there(self):
        _, events = self.traced(BRANCHES)
        names = {event["args"]["name"] for event in events if event["ph"] == "M" and event["name"] == "thread_name"}
        self.assertLessEqual({"first:src", "second:src"}, names)
        self.assertLessEqual({"first", "second"}, {event["name"] for event in events if event["ph"] == "C"})
        self.assertIn("eos", [event["args"]["what"] for event in self.pushes(events, "event")["tensors"]])
        self.assertIn("READY->PAUSED", [event["args"]["what"] for event in self.pushes(events, "state")["converter"]])

    def test_a_multiqueue_is_as_full_as_its_queues_together(self):
        source = "videotestsrc num-buffers=60 ! video/x-raw,width=8,height=8,framerate=300/1"
        branches = [f" {source} ! many.sink_{n} many.src_{n} ! fakesink sync=true" for n in range(2)]
        most = []
        for count in (1, 2):
            _, events = self.traced("multiqueue name=many max-size-buffers=3 max-size-bytes=0 max-size-time=0"
                                    + "".join(branches[:count]))
            most.append(max(event["args"]["frames"] for event in events if event["ph"] == "C" and event["name"] == "many"))
        self.assertIn(most[0], range(2, 6), "three, one that comes and one that leaves")
        # A queue grows beyond its limit while another one is empty.
        self.assertIn(most[1], range(4, 2 * 60 + 1), "both count")

    def test_frames_go_through_bins(self):
        _, events = self.traced("videotestsrc num-buffers=5 ! ( identity name=inside ) ! fakesink name=out")
        pushes = self.pushes(events)
        self.assertEqual((len(pushes["inside"]), len(pushes["out"])), (5, 5))

    def test_what_is_pulled_is_there_too(self):
        sound = self.folder / "sound.wav"
        with wave.open(str(sound), "wb") as file:
            file.setparams((1, 2, 8000, 0, "NONE", ""))
            file.writeframes(bytes(10000))
        _, events = self.traced(f"filesrc name=source location={sound} ! wavparse name=parser ! fakesink")
        pulls = [pull["args"] for pull in self.pushes(events, "pull")["source"]]
        self.assertGreaterEqual(sum(pull["bytes"] for pull in pulls), 10000)
        self.assertEqual({pull["from"] for pull in pulls}, {"parser.sink"})
        self.assertEqual(self.pushes(events)["parser"], [])

    def test_frames_that_are_refused_are_marked(self):
        _, events = self.traced("videotestsrc ! identity name=weak error-after=3 ! fakesink", code=1)
        self.assertEqual([push["args"]["good"] for push in self.pushes(events)["weak"]], [True, True, False])

    def test_a_full_log_is_no_error(self):
        _, events = self.traced("videotestsrc num-buffers=5000 ! video/x-raw,width=8,height=8 ! fakesink name=out",
                                options=",limit=1000")
        self.assertLess(len(self.pushes(events)["out"]), 5000)

    def test_options_that_cannot_be_read_are_reported_and_the_pipeline_runs(self):
        done = weir("run", "fakesrc num-buffers=1 ! fakesink", GST_TRACERS="weir(fle=,limit=none)")
        self.assertEqual(done.returncode, 0)
        for words in ("WEIR-1001: an option of the tracer weir cannot be read", "offered: fle=", "needed: file=PATH"):
            self.assertIn(words, done.stderr)
        (SOURCE / "weir-trace.json").unlink(missing_ok=True)  # the default file, in the current folder of the process

    def test_a_file_that_cannot_be_written_is_reported(self):
        done = weir("run", "fakesrc num-buffers=1 ! fakesink", GST_TRACERS=f"weir(file={self.folder}/no/trace.json)")
        self.assertEqual(done.returncode, 0)
        for words in ("WEIR-4010: the trace cannot be written", "No such file or directory", "fix: GST_TRACERS="):
            self.assertIn(words, done.stderr)

    @unittest.skipIf(SANITIZED, "gst-launch-1.0 cannot load a plug-in that is built with a sanitizer")
    def test_any_program_can_be_traced(self):
        done = subprocess.run(["gst-launch-1.0", "-q", "fakesrc", "num-buffers=3", "!", "fakesink"], cwd=self.folder,
                              env={**os.environ, "GST_TRACERS": "weir"}, capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        events = json.loads((self.folder / "weir-trace.json").read_text())["traceEvents"]
        self.assertEqual(len(self.pushes(events)["fakesink0"]), 3)


if __name__ == "__main__":
    tap_runner.main()
