#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir run --report`: the page against the ledger of the same run, and in a browser."""

import html.parser
import json
import re
import shutil
import signal
import subprocess
import tempfile
import unittest

import tap_runner
from weir_case import COMMAND, SOURCE, Case, weir

VOID = {"meta", "br", "link", "img", "input", "hr"}
CHROMIUM = shutil.which("chromium")


class Page(html.parser.HTMLParser):
    """Collects tables by id, names in the picture, and all text; raises for mismatched tags."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tables, self.names, self.tags, self.text, self.addresses = [], {}, [], set(), "", []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.tags.add(tag)
        self.addresses += [value for name, value in attrs.items() if name in ("href", "src", "xlink:href")]
        if tag not in VOID:
            self.open.append((tag, attrs.get("class")))
        if tag == "table":
            self.rows = self.tables.setdefault(attrs["id"], [])
        elif tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")
        elif (tag, attrs.get("class")) == ("text", "name"):
            self.names.append("")

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        opened, _ = self.open.pop()
        assert opened == tag, f"</{tag}> closes <{opened}>"

    def handle_data(self, data):
        self.text += data
        if self.open and self.open[-1][0] in ("td", "th"):
            self.rows[-1][-1] += data
        elif self.open and self.open[-1] == ("text", "name"):
            self.names[-1] += data

    def table(self, name):
        """The rows as dictionaries with the headings as keys."""
        heading, *rows = self.tables[name]
        return [dict(zip(heading, row)) for row in rows]


class Report(Case):
    FRAMES = 40
    BRANCHES = (f"videotestsrc name=source num-buffers={FRAMES}"
                " ! video/x-raw,format=RGB,width=16,height=8,framerate=30/1 ! tee name=t"
                " t. ! queue name=first ! tensor_converter name=converter"
                " ! tensor_transform name=cast mode=typecast option=float32 ! tensor_sink name=tensors"
                " t. ! queue name=second ! fakesink name=pictures")

    def setUp(self):
        super().setUp()
        self.file = self.folder / "report.html"

    def page(self):
        text = self.file.read_text()
        self.assertNotRegex(text, "https?://")
        page = Page(text)
        self.assertEqual(page.addresses, [])
        self.assertFalse(page.tags & {"script", "link", "iframe", "img", "object"})
        return page

    def reported(self, pipeline, code=0):
        done = weir("run", "--json", "--report", self.file, pipeline)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout), self.page()

    def test_the_page_agrees_with_the_ledger(self):
        report, page = self.reported(self.BRANCHES)
        rows = {row["element"]: row for row in page.table("elements")}
        self.assertEqual(len(report["ledger"]), 3)
        for entry in report["ledger"]:
            row, stats = rows[entry["name"]], entry["stats"]
            self.assertEqual((int(row["frames in"]), int(row["out"]), int(row["bytes copied"]), int(row["dropped"])),
                             (stats["received"], stats["pushed"], stats["bytes-copied"], stats["dropped"]))
            self.assertEqual(row["is a"], entry["element"])
        for sink in report["sinks"]:
            self.assertEqual(int(rows[sink["name"]]["frames in"]), sink["frames"])
        self.assertEqual((rows["t"]["frames in"], rows["t"]["out"]), (str(self.FRAMES), str(2 * self.FRAMES)))

    def test_links_have_frames_and_bytes(self):
        _, page = self.reported(self.BRANCHES)
        links = {(row["from"].split(".")[0], row["to"]): row for row in page.table("links")}
        sizes = {("converter", "cast.sink"): 16 * 8 * 3, ("cast", "tensors.sink"): 4 * 16 * 8 * 3}
        for ends, size in sizes.items():
            self.assertEqual((links[ends]["frames"], links[ends]["bytes"]),
                             (str(self.FRAMES), f"{self.FRAMES * size / 1000:.1f} kB"))

    def clip(self, frames=FRAMES):
        """A file with pictures as JPEG and with sound."""
        file = self.folder / "clip.avi"
        self.good(weir("run", "-q", f"videotestsrc num-buffers={frames} ! video/x-raw,width=64,height=48,framerate=30/1"
                       f" ! jpegenc ! avimux name=muxer ! filesink location={file}"
                       f" audiotestsrc num-buffers={frames} ! audio/x-raw,format=S16LE,rate=8000,channels=1 ! muxer."))
        return file

    def test_links_of_a_decodebin_are_those_that_the_frames_took(self):
        _, page = self.reported(f"filesrc name=file location={self.clip()} ! decodebin name=d"
                                " d. ! queue name=pictures ! video/x-raw ! fakesink name=shown"
                                " d. ! queue name=sound ! audio/x-raw ! fakesink name=heard")
        links = [(row["from"].split(".")[0], row["to"].split(".")[0], row["frames"]) for row in page.table("links")]
        following = {}
        for before, after, _ in links:
            following.setdefault(re.sub("[-0-9]+$", "", before), []).append(re.sub("[-0-9]+$", "", after))
        if parsed := following.pop("jpegparse", None):  # of gstreamer1.0-plugins-bad
            following["multiqueue"] = [*parsed, *(name for name in following["multiqueue"] if name != "jpegparse")]
        self.assertEqual({name: sorted(after) for name, after in following.items()},
                         {"file": ["typefind"], "typefind": ["avidemux"], "avidemux": ["multiqueue"] * 2,
                          "multiqueue": ["jpegdec", "sound"], "jpegdec": ["pictures"],
                          "pictures": ["capsfilter"], "sound": ["capsfilter"], "capsfilter": ["heard", "shown"]})
        self.assertEqual([frames for _, after, frames in links if after == "shown"], [str(self.FRAMES)])
        latencies = {row["to"]: row for row in page.table("latencies")}
        self.assertEqual(set(latencies), {"shown", "heard"})
        for sink, pad in (("shown", "video_0"), ("heard", "audio_0")):
            self.assertRegex(latencies[sink]["from"], rf"^avidemux\d+\.{pad} \(of file\)$")
            self.assertEqual((latencies[sink]["frames"], latencies[sink]["not matched"]), (str(self.FRAMES), "0"))

    def test_the_picture_shows_each_element_once(self):
        _, page = self.reported(self.BRANCHES)
        self.assertEqual(sorted(page.names), sorted(row["element"] for row in page.table("elements")))
        self.assertLessEqual({"source", "t", "first", "second", "converter", "cast", "tensors", "pictures"},
                             set(page.names))
        order = page.names.index
        for before, after in (("source", "t"), ("t", "first"), ("first", "converter"), ("converter", "cast"),
                              ("cast", "tensors"), ("second", "pictures")):
            self.assertLess(order(before), order(after))

    def test_latency_goes_to_each_sink_and_counts_each_frame(self):
        _, page = self.reported(self.BRANCHES)
        rows = {(row["from"], row["to"]): row for row in page.table("latencies")}
        self.assertEqual(set(rows), {("source", "tensors"), ("source", "pictures")})
        for row in rows.values():
            self.assertEqual((row["frames"], row["not matched"]), (str(self.FRAMES), "0"))
        counted = sum(int(n) for n in re.findall(r": (\d+) frames</title></rect>", self.file.read_text()))
        self.assertEqual(counted, 2 * self.FRAMES)

    def test_queues_show_what_they_lost(self):
        report, page = self.reported("videotestsrc num-buffers=50 ! queue name=leak leaky=downstream max-size-buffers=3"
                                   " ! identity sleep-time=2000 ! fakesink name=out")
        queue = page.table("queues")[0]
        frames = {sink["name"]: sink["frames"] for sink in report["sinks"]}["out"]
        self.assertEqual((queue["queue"], int(queue["not passed on"])), ("leak", 50 - frames))
        self.assertLessEqual(int(queue["most frames"]), 4)
        self.assertIn('class="levels"', self.file.read_text())

    def test_names_cannot_change_the_page(self):
        name = '<script>alert("1")</script>&amp;\'<b>'
        quoted = name.replace('"', '\\"')
        _, page = self.reported(f'videotestsrc num-buffers=2 ! identity name="{quoted}" ! fakesink')
        self.assertIn(name, [row["element"] for row in page.table("elements")])
        self.assertTrue(any(page_name.startswith("<script>alert(") for page_name in page.names))

    def test_an_error_is_reported_with_its_fix(self):
        report, page = self.reported("videotestsrc num-buffers=1 ! tensor_converter"
                                   " ! tensor_transform name=cast mode=typecast option=flot32 ! fakesink", code=1)
        self.assertEqual(report["result"], "error")
        for words in ("Failed", "cast: WEIR-1001", "flot32", "fix: "):
            self.assertIn(words, page.text)

    def document(self, pipeline, code=0):
        """The report as JSON."""
        file = self.folder / "report.json"
        done = weir("run", "-q", "--report", file, pipeline)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(file.read_text())

    def element(self, document, name):
        return next(element for element in document["trace"]["elements"] if element["name"] == name)

    def test_the_verdict_names_the_element_that_takes_most_of_the_time(self):
        slow = ("videotestsrc num-buffers=30 ! video/x-raw,width=8,height=8 ! queue ! identity name=slow sleep-time=5000"
                " ! fakesink sync=false")
        verdict = self.document(slow)["verdict"]
        self.assertEqual((verdict["kind"], verdict["element"]), ("bottleneck", "slow"))
        self.assertGreater(verdict["share"], 0.8)
        self.assertRegex(verdict["text"], r"^slow takes \d+ % of the time: the bottleneck\.$")
        _, page = self.reported(slow)
        self.assertRegex(page.text, r"slow takes \d+ % of the time: the bottleneck\.")

    def test_a_pipeline_that_waits_for_the_clock_keeps_up(self):
        for source, sink, waiting in (("is-live=true", "sync=false", "source"), ("is-live=false", "sync=true", "sink")):
            document = self.document(f"videotestsrc name=source {source} num-buffers=30"
                                     " ! video/x-raw,width=8,height=8,framerate=50/1"
                                     f" ! identity name=between ! fakesink name=sink {sink}")
            self.assertEqual(document["verdict"]["kind"], "keeps-up", document["verdict"])
            self.assertGreater(self.element(document, waiting)["waiting_share"], 0.7)
            for name in ("source", "between", "sink"):
                self.assertLess(self.element(document, name)["share"], 0.3, name)

    def test_a_model_works_while_the_thread_of_the_stream_waits_for_it(self):
        model = SOURCE / "models" / "clock_digits.onnx"
        line = ("videotestsrc num-buffers=200 ! video/x-raw,format=GRAY8,width=192,height=32 ! tensor_converter"
                f" ! tensor_transform mode=typecast option=float32 ! tensor_filter name=net {{}} model={model} ! fakesink")
        if weir("inspect", model).returncode:
            self.skipTest("there is no engine for the model")
        for workers in (1, 2):
            net = self.element(self.document(line.format(f"workers={workers}")), "net")
            self.assertEqual(net["stats"]["invokes"], 200)
            self.assertGreater(net["share"], 0)
            self.assertLessEqual(net["waiting_share"], 1 if workers == 1 else 0)

    def test_a_queue_waits_and_does_not_work(self):
        document = self.document("videotestsrc num-buffers=50 ! video/x-raw,width=8,height=8 ! queue name=full"
                                 " max-size-buffers=1 ! identity name=slow sleep-time=3000 ! fakesink")
        queue = self.element(document, "full")
        self.assertEqual((queue["waits"], queue["work"], queue["thread_work"]), ("room", 0, 0))
        self.assertGreater(queue["waiting_share"], 0.8)

    def test_without_a_frame_at_a_sink_the_verdict_says_where_they_end(self):
        verdict = self.document("videotestsrc num-buffers=5 ! identity name=shut drop-probability=1 ! fakesink async=false")["verdict"]
        self.assertEqual((verdict["kind"], verdict["text"]),
                         ("nothing-ran", "No frame reached a sink: shut received 5 frames and pushed none."))

    def test_the_element_that_failed_is_marked(self):
        pipeline = ("videotestsrc num-buffers=1 ! tensor_converter ! tensor_transform name=cast mode=typecast option=flot32"
                    " ! fakesink")
        document = self.document(pipeline, code=1)
        self.assertEqual(document["verdict"]["kind"], "failed")
        self.assertTrue(document["verdict"]["text"].startswith("cast failed: "), document["verdict"]["text"])
        failed = [element["name"] for element in document["trace"]["elements"] if element["failed"]]
        self.assertIn("cast", failed)
        self.assertNotIn("tensor_converter", [self.element(document, name)["factory"] for name in failed])
        self.reported(pipeline, code=1)
        self.assertIn('class="box failed"', self.file.read_text())

    def test_an_error_of_a_bin_marks_what_is_in_it(self):
        text = self.folder / "words.txt"
        text.write_text("no picture and no sound\n" * 100)
        document = self.document(f"filesrc location={text} ! decodebin name=d ! fakesink name=out", code=1)
        self.assertIn("d", {error["element"] for error in document["outcome"]["errors"]}, document["outcome"]["errors"])
        failed = {element["name"]: element["failed"] for element in document["trace"]["elements"]}
        self.assertTrue(failed["typefind"])
        self.assertFalse(failed["out"])

    def test_the_verdict_is_printed_too(self):
        done = weir("run", "--report", self.file, "fakesrc num-buffers=20 ! identity sleep-time=3000 name=slow ! fakesink")
        self.assertRegex(self.good(done), r"\n\nslow takes \d+ % of the time: the bottleneck\.\nReport: ")

    def test_links_have_caps_and_elements_their_properties(self):
        document = self.document(self.BRANCHES)
        caps = {document["trace"]["elements"][link["to"]]["name"]: link["caps"] for link in document["trace"]["links"]}
        self.assertIn("format=(string)RGB, width=(int)16, height=(int)8", caps["converter"])
        self.assertIn("float32", caps["tensors"])
        self.assertEqual(self.element(document, "cast")["properties"], {"mode": "typecast", "option": "float32"})
        self.assertEqual(self.element(document, "t")["properties"], {})
        self.assertEqual(set(document), {"verdict", "pipeline", "host", "versions", "outcome", "trace"})
        self.assertEqual(document["versions"]["gstreamer"].split(".")[0], "1")
        self.assertGreaterEqual(document["host"]["cores"], 1)

    def test_the_engines_in_use_have_their_versions(self):
        model = self.folder / "model"
        model.write_text("any")
        line = ("videotestsrc num-buffers=2 ! video/x-raw,format=RGBA,width=4,height=1 ! tensor_converter"
                f" ! tensor_transform mode=typecast option=float32 ! tensor_filter framework=fake model={model} ! fakesink")
        self.assertEqual(self.document(line)["versions"]["engines"], {"fake": "1"})
        _, page = self.reported(line)
        self.assertRegex(page.text, r"weir \d+\.\d+\.\d+, GStreamer \d+\.\d+\.\d+, fake 1; ")
        for other in (line.replace("framework=fake", "framework=fake isolate=process"), self.BRANCHES):
            self.assertEqual(self.document(other)["versions"]["engines"], {}, "this process has no engine")

    def test_passwords_are_not_shown(self):
        done = weir("run", "--report", self.file, 'videotestsrc num-buffers=1 ! fakesink name="rtsp://me:pass1@camera/x"'
                    ' souphttpsrc location=http://me:pass2@localhost:1/ user-pw=pass3 ! fakesink')
        self.assertEqual(done.returncode, 1, done.stderr)
        text = self.file.read_text()
        self.assertIn("location=http://***@localhost:1/ user-pw=***", text)
        self.assertRegex(text, "Could not connect|Internal data stream error")  # with libsoup 2 and 3
        self.assertNotRegex(text, "pass[123]")

    def test_caps_cannot_change_the_page(self):
        _, page = self.reported('videotestsrc num-buffers=2 ! video/x-raw,width=8,height=8'
                                ',note=(string)"<script>alert(2)</script>" ! fakesink')
        caps = " ".join(row["caps"] for row in page.table("links"))
        self.assertIn("<script>alert(2)</script>", caps.replace("\\", ""))

    def test_an_interrupted_run_is_reported(self):
        frames = self.folder / "frames"
        pipeline = ("videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=8,height=8,framerate=100/1"
                    f" ! filesink buffer-mode=unbuffered location={frames}")
        running = subprocess.Popen([COMMAND, "run", "--report", self.file, pipeline], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        while running.poll() is None and not (frames.exists() and frames.stat().st_size > 20 * 8 * 8):
            pass
        running.send_signal(signal.SIGINT)
        output, errors = running.communicate(timeout=30)
        self.assertEqual(running.returncode, 130, errors)
        self.assertIn(f"Report: {self.file}\n", output)
        self.assertIn("Interrupted", self.page().text)

    def test_the_tracer_that_runs_already_is_taken(self):
        trace = self.folder / "trace.json"
        done = weir("run", "--report", self.file, self.BRANCHES, GST_TRACERS=f"weir(file={trace})")
        self.good(done)
        pushes = [e for e in json.loads(trace.read_text())["traceEvents"] if e.get("cat") == "push"]
        self.assertEqual(sum(e["name"] == "tensors" for e in pushes), self.FRAMES)
        rows = {row["element"]: row for row in self.page().table("elements")}
        self.assertEqual(rows["tensors"]["frames in"], str(self.FRAMES))

    def test_lost_records_are_reported(self):
        self.good(weir("run", "--report", self.file, "videotestsrc num-buffers=5000 ! video/x-raw,width=8,height=8"
                       " ! fakesink", GST_TRACERS="weir(file=,limit=1000)"))
        self.assertIn("records are missing", self.page().text)

    def test_a_place_that_cannot_be_written_is_refused_before_the_run(self):
        place = self.folder / "none" / "report.html"
        self.refused(weir("run", "--report", place, "videotestsrc ! fakesink"), 1,  # would never end
                     "WEIR-4010: the report cannot be written", "No such file or directory", "fix: weir run --report")
        report = json.loads(weir("run", "--json", "--report", place, "videotestsrc ! fakesink").stdout)
        self.assertEqual((report["error"]["id"], report["error"]["offered"]), ("WEIR-4010", str(place)))

    def test_without_the_plugin_there_is_no_report(self):
        self.refused(weir("run", "--report", self.file, "fakesrc num-buffers=1 ! fakesink", GST_PLUGIN_PATH="",
                          GST_PLUGIN_SYSTEM_PATH_1_0=str(self.folder / "none"),
                          GST_REGISTRY=str(self.folder / "registry")), 1, "the tracer weir is not found", "fix: weir doctor")
        self.assertFalse(self.file.exists())

    @unittest.skipUnless(CHROMIUM, "chromium is not installed (apt-get install chromium)")
    def test_a_browser_shows_it_and_runs_nothing_of_it(self):
        pipeline = self.BRANCHES + ' t. ! queue ! fakesink name="<script>document.title=1</script>"'
        self.reported(pipeline)
        picture = self.folder / "picture.png"
        with tempfile.TemporaryDirectory() as profile:
            options = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}",
                       "--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1400,1800"]
            shown = subprocess.run([*options, "--dump-dom", self.file.as_uri()], capture_output=True, text=True,
                                   timeout=120)
            self.assertEqual(shown.returncode, 0, shown.stderr)
            subprocess.run([*options, f"--screenshot={picture}", self.file.as_uri()], capture_output=True, check=True,
                           timeout=120)
        self.assertIn("<title>Pipeline report</title>", shown.stdout)
        names = Page(shown.stdout.replace("<!DOCTYPE html>", "")).names
        self.assertIn("converter", names)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        self.assertGreater(picture.stat().st_size, 20000)  # an empty page of this size has a few thousand bytes


if __name__ == "__main__":
    tap_runner.main()
