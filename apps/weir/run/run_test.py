#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir run`: the final ledger, errors, interrupts."""

import hashlib
import json
import os
import pathlib
import pty
import re
import signal
import socket
import struct
import subprocess
import threading

import tap_runner
from weir_case import COMMAND, Case, weir


class Run(Case):
    PIPELINE = "videotestsrc num-buffers=7 ! tensor_converter ! tensor_sink name=out"

    def test_it_ends_with_the_ledger(self):
        done = weir("run", self.PIPELINE)
        output = self.good(done)
        self.assertRegex(output, r"Ended [\d.]+ s after the first frame: 7 frames")
        self.assertRegex(output, r"out +7 +7 +0")
        self.assertNotIn("\033", output + done.stderr)

    def test_the_pipeline_may_be_many_arguments(self):
        self.assertIn("7 frames", self.good(weir("run", *self.PIPELINE.split())))

    def test_an_error_ends_a_run_whose_other_branches_still_stream(self):
        branch = "videotestsrc ! video/x-raw,width=16,height=16 ! "
        text = f"{branch}fakesink {branch}fakesink {branch}fakesink {branch}identity error-after=100 ! fakesink"
        for _ in range(5):
            self.assertEqual(weir("run", text).returncode, 1)

    def test_json(self):
        report = json.loads(self.good(weir("run", "--json", self.PIPELINE)))
        self.assertEqual((report["result"], report["frames"]), ("eos", 7))
        stats = {entry["element"]: entry["stats"] for entry in report["ledger"]}
        self.assertEqual(stats["tensor_sink"]["consumed"], 7)
        self.assertEqual(stats["tensor_converter"]["pushed"], 7)

    def test_options_stand_before_or_after_the_pipeline(self):
        for words in (("--json", self.PIPELINE), (self.PIPELINE, "--json"), (*self.PIPELINE.split(), "--json")):
            self.assertEqual(json.loads(self.good(weir("run", *words)))["frames"], 7)
        self.refused(weir("run", self.PIPELINE, "--jsn"), 2, "weir run has no option '--jsn'. Did you mean '--json'?")

    def test_quiet_prints_warnings_and_errors_only(self):
        done = weir("run", "-q", self.PIPELINE)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        done = weir("run", "-q", "videotestsrc ! identity name=weak error-after=2 ! fakesink")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("error from weak: ", done.stderr)
        self.refused(weir("run", "-q", "-v", self.PIPELINE), 2, "excludes --quiet")

    def test_verbose_prints_the_caps(self):
        done = weir("run", "-v", "videotestsrc num-buffers=1 ! video/x-raw,format=GRAY8,width=16 ! fakesink name=out")
        self.good(done)
        self.assertRegex(done.stderr, r"\nvideotestsrc0\.src: caps = video/x-raw, format=\(string\)GRAY8, width=\(int\)16, ".lstrip("\\n"))
        self.assertRegex(done.stderr, r"out\.sink: caps = video/x-raw, ")

    def test_the_stream_ends_after_the_time_of_timeout(self):
        done = self.run_for(0.3, "--json", "videotestsrc is-live=true ! fakesink")
        report = json.loads(self.good(done))
        self.assertEqual((report["result"], report["errors"]), ("time-limit", []))
        self.assertGreater(report["frames"], 0)
        self.assertGreaterEqual(report["seconds"] + report["seconds_to_start"], 0.3)
        self.assertIn("Ended ", self.good(weir("run", "--timeout", "250", self.PIPELINE)))
        self.assertIn("Stopped by --timeout ", self.good(self.run_for(1, "videotestsrc is-live=true ! fakesink")))

    def test_frames_on_the_way_are_waited_for_after_timeout(self):
        done = self.run_for(0.4, "--json", "videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=8,height=8,framerate=100/1 ! "
                            "tensor_converter ! queue ! identity sleep-time=40000 ! fakesink")
        report = json.loads(self.good(done))
        self.assertEqual(report["result"], "time-limit")
        self.assertEqual(report["frames"], report["ledger"][0]["stats"]["received"])

    def test_a_pipeline_that_does_not_start_is_an_error_of_timeout(self):
        done = weir("run", "--timeout", "0.2", "appsrc ! fakesink")
        self.refused(done, 1, "error: the pipeline did not reach PLAYING within the time of --timeout", "needed: a first buffer at each sink")
        self.refused(weir("run", "--timeout", "0", self.PIPELINE), 2, "weir run: --timeout: ")

    def test_a_file_has_buffers_and_its_video_has_frames(self):
        line = ("videotestsrc num-buffers=12 ! video/x-raw,width=64,height=48 ! theoraenc ! oggmux name=m ! fakesink name=out "
                "audiotestsrc num-buffers=5 ! vorbisenc ! m.")
        output = self.good(weir("run", line))
        self.assertRegex(output, r"Ended [\d.]+ s after the first frame: 12 frames, [\d.]+ frames/s; the first frame came after [\d.]+ s\n")
        self.assertRegex(output, r"\n  out: \d+ buffers\n")
        self.assertRegex(output, r"\n  m: 12 frames\n")
        report = json.loads(self.good(weir("run", "--json", "audiotestsrc num-buffers=5 ! fakesink name=out")))
        self.assertEqual((report["frames"], report["buffers"], report["sinks"]), (0, 5, [{"name": "out", "buffers": 5}]))

    def test_frames_of_an_element_that_joins_tensors_are_counted_at_the_sink_only(self):
        tensors = "videotestsrc num-buffers=4 ! tensor_converter ! m. " * 2
        for line, count in ((f"tensor_mux name=m ! fakesink name=out {tensors}", "frames"),
                            (f"tensor_merge name=m mode=linear option=3 ! fakesink name=out {tensors}", "frames"),
                            (f"tensor_mux name=m ! tensor_decoder mode=octet_stream ! fakesink name=out {tensors}", "buffers")):
            report = json.loads(self.good(weir("run", "--json", line)))
            self.assertEqual((report[count], report["sinks"]), (4, [{"name": "out", count: 4}]))

    def test_the_fix_of_a_stream_that_does_not_fit_the_model_is_its_card(self):
        model, path = self.folder / "planar.bin", self.folder / "planar.card.json"
        model.write_text("the engine only looks at the name")
        picture = {"name": "picture", "type": "float32", "shape": [1, 3, 16, 24], "layout": "NCHW", "color": "RGB", "mean": [127.5],
                   "scale": [0.007843], "resize": "stretch"}
        card = {"name": "planar", "model": "planar.bin", "sha256": hashlib.sha256(model.read_bytes()).hexdigest(), "task": "none",
                "inputs": [picture], "outputs": [], "labels": ["a"], "decoder": "image_labeling", "provenance": {}}
        path.write_text(json.dumps(card))
        source, network = "videotestsrc num-buffers=2", f"tensor_filter framework=fake-models model={model} ! fakesink"
        done = weir("run", f"{source} ! tensor_converter ! {network}")
        fix = f"tensor_preprocess card={path} ! tensor_filter"
        self.refused(done, 1, "WEIR-2001: the stream does not fit the model", f"fix: videoconvert ! {fix}\n")
        self.good(weir("run", f"{source} ! {fix} {network.removeprefix('tensor_filter ')}"))
        # A card that does not make what the model needs is no fix.
        path.write_text(json.dumps(card | {"inputs": [picture | {"shape": [1, 3, 8, 8]}]}))
        done = weir("run", f"{source} ! tensor_converter ! {network}")
        self.refused(done, 1, "WEIR-2001", "; assumed: pixels as the mean and deviation of ImageNet, RGB, stretched",
                     "fix: videoconvert ! tensor_preprocess width=24 height=16 layout=NCHW mean=123.675,116.28,103.53 scale=0.017")

    def test_a_missing_file_is_named(self):
        (self.folder / "street.mp4").write_bytes(b"")
        for place, words in (("stret.mp4", ("the file does not exist", f"fix: location={self.folder}/street.mp4")),
                             ("none", ("the file does not exist",)), ("", ("the location is a folder", f"such as {self.folder}/NAME"))):
            location = self.folder / place
            done = weir("run", f"filesrc name=file location={location} ! fakesink")
            self.refused(done, 1, "error from file: WEIR-4001: ", f"offered: location={location}", *words)
            self.assertEqual(done.stderr.count("error"), 1, done.stderr)
        self.refused(weir("run", f"uridecodebin uri=file://{self.folder}/stret.mp4 ! fakesink"), 1, "WEIR-4001: ", "did you mean street.mp4?")

    def test_a_file_of_an_unknown_format_is_named(self):
        path = self.folder / "notes.txt"
        for content, words in ((b"hello\n", "the format of the file is not known"), (b"", "the file is empty")):
            path.write_bytes(content)
            for source in (f"filesrc location={path} ! decodebin", f"filesrc location={path} ! typefind", f"uridecodebin uri=file://{path}"):
                done = weir("run", f"{source} ! fakesink")
                self.refused(done, 1, f": WEIR-2002: {words}\n  offered: {path}\n  needed: a picture, a video or a sound\n")
                self.assertEqual(done.stderr.count("error"), 1, done.stderr)

    def test_filters_have_their_times(self):
        model = self.folder / "model"
        model.write_text("any")
        output = self.good(weir("run", "videotestsrc num-buffers=3 ! video/x-raw,format=RGBA,width=4,height=1 ! tensor_converter ! "
                                f"tensor_transform mode=typecast option=float32 ! tensor_filter name=f framework=fake model={model} ! fakesink"))
        self.assertRegex(output, r"\nFilters\n  filter +invokes +mean ms +p99 ms\n  f +3 +[\d.]+ +[\d.]+\n")
        self.assertNotIn("Filters", self.good(weir("run", self.PIPELINE)))

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

    def test_progress_has_a_percentage_where_the_length_is_known(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        line = "filesrc location={} ! decodebin ! fakesink sync=true"
        clip = self.folder / "clip.ogg"
        self.good(weir("run", f"videotestsrc num-buffers=60 ! video/x-raw,width=64,height=48 ! theoraenc ! oggmux ! filesink location={clip}"))
        running = subprocess.Popen([COMMAND, "run", line.format(clip)], stdout=subprocess.PIPE, stderr=theirs, text=True)
        os.close(theirs)
        seen = ""
        while not re.search(r"frames/s  \d+ %  \d+ s left\r", seen):
            seen += os.read(ours, 1000).decode()  # raises when the process has ended
        running.communicate(timeout=30)
        self.assertEqual(running.returncode, 0)

    def test_warnings_are_printed_when_they_happen(self):
        running = self.start("videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=8,height=8 ! tensor_converter ! "
                             "tensor_aggregator name=a frames-out=2 frames-dim=9 ! fakesink")
        self.assertIn("warning from a: WEIR-1004: frames-dim is beyond", running.stderr.readline())
        running.send_signal(signal.SIGINT)
        output, errors = self.interrupted(running)
        self.assertNotIn("warning", output + errors, "it is printed once")

    def test_errors_of_elements_come_with_their_fix(self):
        done = weir("run", "videotestsrc num-buffers=1 ! tensor_converter ! tensor_transform mode=typecast option=flot32 ! fakesink")
        self.refused(done, 1, "WEIR-1001", "flot32", "fix: ", "Failed without a frame")

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

    def test_a_file_to_write_in_no_folder_is_named_with_the_reason(self):
        for location, words in ((self.folder, (": the location is a folder\n", f"such as {self.folder}/NAME\n")),
                                (self.folder / "no" / "x", (": the folder of the file does not exist\n", f"fix: mkdir -p {self.folder}/no\n"))):
            done = weir("run", "-q", f"videotestsrc num-buffers=1 ! filesink name=out location={location}")
            self.refused(done, 1, "error from out: WEIR-4010", f"offered: location={location}\n", *words)
            self.assertEqual(done.stderr.count("error from"), 1)

    def test_a_state_change_that_failed_has_one_error_with_the_reason(self):
        done = weir("run", "filesrc ! fakesink")
        self.refused(done, 1, "error from filesrc0: No file name specified for reading.")
        self.assertNotIn("failed to post a proper error message", done.stderr)

    def test_errors_of_other_elements_come_with_their_details(self):
        done = weir("run", "videotestsrc ! identity name=weak error-after=2 ! fakesink")
        self.refused(done, 1, "error from weak: Failed after iterations as requested.\n", "Failed ")
        done = weir("run", f"multifilesrc name=weak location={self.folder}/no-%d ! fakesink")
        self.refused(done, 1, "error from weak: ", "  details: Failed to open file ", "No such file or directory\n")

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
            self.assertIn("Interrupted ", output)
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
            self.assertIn("Interrupted ", self.interrupted(running)[0])

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

    FILE = "jpegenc ! qtmux ! filesink name=file location={out}"

    def frames_of_the_file(self):
        """How many pictures a player finds in an MP4 file, whose index comes last."""
        return json.loads(self.good(weir("run", "--json", f"filesrc location={self.out} ! qtdemux ! jpegdec ! fakesink")))["frames"]

    def test_a_file_is_complete_after_an_error(self):
        live = "videotestsrc is-live=true ! video/x-raw,width=16,height=16,framerate=100/1 ! "
        for text in (f"{live}identity error-after=31 ! {self.FILE}",
                     f"{live}tee name=t t. ! queue ! {self.FILE} t. ! queue ! identity error-after=31 ! fakesink",
                     f"{live}identity error-after=31 ! fakesink {live}bin.( jpegenc ! queue ! qtmux ) ! queue ! filesink location={{out}}"):
            with self.subTest(text):
                running = self.start(text)
                output, errors = running.communicate(timeout=60)
                self.assertEqual(running.returncode, 1, output + errors)
                self.assertIn("error from identity0: ", errors)
                self.assertNotIn("incomplete", errors)
                self.assertGreater(self.frames_of_the_file(), 20)

    def test_a_file_is_complete_when_its_stream_does_not_end(self):
        # imagefreeze goes on after the EOS of its source.
        endless = ("videotestsrc num-buffers=1 ! imagefreeze is-live=true ! video/x-raw,framerate=100/1,format=I420,width=16,height=16 ! "
                   "tee name=t t. ! queue ! filesink location={out}.raw buffer-mode=unbuffered t. ! queue ! ")
        for text in (self.FILE, "jpegenc ! splitmuxsink muxer=qtmux location={out}%d"):
            with self.subTest(text):
                running = self.start(endless + text)
                self.out = self.out.with_suffix(".raw")
                self.wait_for_frames(running)
                running.send_signal(signal.SIGINT)
                self.assertIn("interrupt again to stop at once", running.stderr.readline())
                running.send_signal(signal.SIGTERM)
                _, errors = self.interrupted(running)
                self.assertNotIn("incomplete", errors)
                files = sorted(each for each in self.folder.glob("frames*") if each.suffix != ".raw")
                self.assertEqual(len(files), 1)
                self.out = files[0]
                self.assertGreater(self.frames_of_the_file(), 0)
                for each in self.folder.iterdir():
                    each.unlink()

    def test_a_file_that_eos_cannot_reach_is_not_waited_for(self):
        for end, place in (("filesink location=/dev/full", "filesink0"), ("queue ! identity error-after=5 ! filesink location={out}", "identity0")):
            running = self.start(f"videotestsrc num-buffers=500 ! jpegenc ! qtmux ! {end}")
            output, errors = running.communicate(timeout=60)
            self.assertEqual(running.returncode, 1, output + errors)
            self.assertIn(f"error from {place}: ", errors)
            self.assertNotIn("incomplete", errors)

    def serve_rtsp(self, says_goodbye):
        """The port of a camera that sends sound over its RTSP connection, nothing by UDP, and then closes it."""
        def respond(peer, lines):
            for line in lines:
                method, fields = line.split()[0], {}
                while (line := next(lines)).strip():
                    name, value = line.split(b":", 1)
                    fields[name.lower()] = value.strip()
                is_tcp = b"TCP" in fields.get(b"transport", b"TCP")
                body = b"v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\nm=audio 0 RTP/AVP 0\r\na=control:0\r\n" if method == b"DESCRIBE" else b""
                peer.sendall(b"RTSP/1.0 200 OK\r\nCSeq: " + fields[b"cseq"] + b"\r\n" + {
                    b"OPTIONS": b"Public: DESCRIBE, SETUP, PLAY, TEARDOWN\r\n",
                    b"DESCRIBE": b"Content-Type: application/sdp\r\nContent-Length: %d\r\n" % len(body),
                    b"SETUP": b"Session: 1\r\nTransport: " + (b"RTP/AVP/TCP;unicast;interleaved=0-1" if is_tcp else fields[b"transport"] + b";server_port=9-10")
                    + b"\r\n"}.get(method, b"Session: 1\r\n") + b"\r\n" + body)
                if method == b"SETUP" and is_tcp:
                    self.tcp.set()
                if method == b"PLAY" and self.tcp.is_set():
                    return

        def serve():
            while not self.tcp.is_set():
                with self.listener.accept()[0] as peer, peer.makefile("rb") as lines:
                    respond(peer, lines)
                    for number in range(50 if self.tcp.is_set() else 0):
                        packet = struct.pack(">BBHII", 0x80, 0, number, 160 * number, 1) + bytes(160)
                        peer.sendall(b"$\0" + struct.pack(">H", len(packet)) + packet)
                        self.pause.wait(0.02)
                    if self.tcp.is_set() and says_goodbye:
                        peer.sendall(b"$\1\0\x10" + struct.pack(">BBHIBBHI", 0x80, 201, 1, 1, 0x81, 203, 1, 1))
                        peer.settimeout(30)
                        while peer.recv(4096):
                            pass
        self.listener, self.pause, self.tcp = socket.create_server(("127.0.0.1", 0)), threading.Event(), threading.Event()
        self.addCleanup(self.listener.close)
        server = threading.Thread(target=serve)
        server.start()
        self.addCleanup(server.join)
        return self.listener.getsockname()[1]

    def record_sound(self, source):
        out = self.folder / "sound.wav"
        done = weir("run", f"rtspsrc {source} latency=100 name=camera ! rtppcmudepay ! mulawdec ! wavenc ! filesink location={out}")
        self.assertGreater(out.stat().st_size, 1000)
        return done

    def test_a_camera_whose_connection_breaks_off_is_an_error(self):
        done = self.record_sound(f"location=rtsp://127.0.0.1:{self.serve_rtsp(False)}/ protocols=tcp")
        self.refused(done, 1, "error from camera: ", "The server closed the connection")

    def test_a_camera_that_is_reached_at_the_second_attempt_is_no_error(self):
        done = self.record_sound(f"location=rtsp://127.0.0.1:{self.serve_rtsp(True)}/ timeout=100000")
        self.assertIn("Ended ", self.good(done))
        self.assertIn("Retrying using a tcp connection", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
