#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tensor_filter framework=oip in whole pipelines, with an inference server of Python's grpcio."""

import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

import numpy as np

import onnx_writer
import tap_runner
from built_modules import has_engine
from peer_process import start_grpcio_server

FRAMES = 20
# Plays a pipeline and prints what the meta of each frame before `end` says.
WHO_ANSWERED = """
import sys, gi
gi.require_version("Gst", "1.0")
from gi.repository import Gst
Gst.init(None)
pipeline = Gst.parse_launch(sys.argv[1])
def seen(pad, info):
    meta = info.get_buffer().get_custom_meta("WeirAnsweredBy")
    print(meta.get_structure().to_string() if meta else "-")
    return Gst.PadProbeReturn.OK
pipeline.get_by_name("end").get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER, seen)
pipeline.set_state(Gst.State.PLAYING)
message = pipeline.get_bus().timed_pop_filtered(60 * Gst.SECOND, Gst.MessageType.ERROR | Gst.MessageType.EOS)
print(message.parse_error() if message.type == Gst.MessageType.ERROR else "end")
pipeline.set_state(Gst.State.NULL)
"""


def interrupt(process):
    """As by Ctrl-C. gst-launch-1.0 takes it only once it prerolls, which may be after the first request."""
    def takes_it():
        caught = re.search(r"SigCgt:\s*(\w+)", pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8"))
        return int(caught[1], 16) >> signal.SIGINT - 1 & 1

    while not takes_it() and process.poll() is None:
        pass
    process.send_signal(signal.SIGINT)


class InferenceServer(unittest.TestCase):
    def setUp(self):
        if not has_engine("oip"):
            self.skipTest("the engine oip is not built")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.frames = np.random.default_rng(1).normal(size=(FRAMES, 4)).astype(np.float32)

    def server(self, *options):
        """The address of the model `affine`, y = 2 x + 1, of a server that this starts."""
        process, port = start_grpcio_server(self, *options)
        return process, f"grpc://127.0.0.1:{port}/affine/1"

    def line(self, model, options, data, data_type="float32", before=""):
        (self.folder / "in").write_bytes(data.tobytes())
        return (f"filesrc location={self.folder}/in blocksize={data[0].nbytes} ! application/octet-stream,framerate=30/1 ! "
                f"tensor_converter input-dim=4:1 input-type={data_type} ! {before}"
                f"tensor_filter framework=oip model={model} {options} ! filesink async=false location={self.folder}/out")

    def play(self, model, options="", data=None, data_type="float32", debug="1", before=""):
        line = self.line(model, options, self.frames if data is None else data, data_type, before)
        return subprocess.run(["gst-launch-1.0", *line.split()], capture_output=True, text=True, timeout=120,
                              stdin=subprocess.DEVNULL, env={**os.environ, "GST_DEBUG": debug, "GST_TRACERS": ""})

    def result(self):
        return np.fromfile(self.folder / "out", np.float32).reshape(-1, 4)

    def test_frames_are_answered_in_their_order(self):
        for options in ("", "workers=4"):
            _, model = self.server("--delays", "0.02,0,0.01")
            done = self.play(model, options)
            self.assertEqual(done.returncode, 0, done.stderr)
            np.testing.assert_allclose(self.result(), 2 * self.frames + 1, rtol=1e-6)

    def test_several_requests_are_in_flight_without_another_property(self):
        for custom, most in (("in-flight:4", 4), ("in-flight:2", 2), ("idempotent:false", 1), ("in-flight:4 workers=2", 2)):
            process, model = self.server("--delay", "0.1")
            done = self.play(model, f"custom={custom}")
            self.assertEqual(done.returncode, 0, done.stderr)
            np.testing.assert_allclose(self.result(), 2 * self.frames + 1, rtol=1e-6)
            process.terminate()
            self.assertEqual(process.stdout.read(), f"requests {FRAMES} most {most}\n", custom)

    def test_the_deadline_of_a_frame_reaches_the_server(self):
        for options, low, high in (("deadline=5000000000", 3, 5.01), ("custom=timeout-ms:2000", 1, 2.01),
                                   ("deadline=5000000000 custom=timeout-ms:2000", 1, 2.01)):
            process, model = self.server("--print-times")
            done = self.play(model, options, before="identity sync=true ! ")  # without a clock, frames have no deadline
            self.assertEqual(done.returncode, 0, done.stderr)
            process.terminate()
            left = [float(seconds) for seconds in re.findall(r"left ([0-9.]+)\n", process.stdout.read())]
            self.assertEqual(len(left), FRAMES)
            self.assertGreater(min(left), low, options)
            self.assertLessEqual(max(left), high, options)

    def local_model(self, add=1001, width=4):
        """A model of a file: y = 2 x + 1001, which tells its answers from those of a server."""
        if not has_engine("onnxruntime"):
            self.skipTest("the engine onnxruntime is not built")
        path = self.folder / "local.onnx"
        path.write_bytes(onnx_writer.model([("Mul", ["x", "two"], "t"), ("Add", ["t", "add"], "y")],
                                           {"two": np.full(1, 2, np.float32), "add": np.full(1, add, np.float32)},
                                           [("x", ["n", width])], [("y", ["n", width])]))
        return path

    def answers(self):
        """The frames that the server answered, and those that the local model did; together they are all, in order."""
        away = self.result()[:, 0] - (2 * self.frames[:, 0] + 1)
        np.testing.assert_allclose(self.result() - np.round(away)[:, None], 2 * self.frames + 1, rtol=0, atol=1e-3)
        return int(np.sum(np.round(away) == 0)), int(np.sum(np.round(away) == 1000))

    def test_a_fallback_answers_while_the_server_is_away(self):
        self.frames = np.random.default_rng(2).normal(size=(60, 4)).astype(np.float32)
        _, model = self.server("--away", "10:6")
        done = self.play(model, f"fallback={self.local_model()} custom=probe-ms:20,attempts:1 ! identity sync=true",
                         debug="tensor_filter:4,weir-oip:4")
        self.assertEqual(done.returncode, 0, done.stderr)
        remote, local = self.answers()
        self.assertEqual(remote + local, 60)
        self.assertGreaterEqual(local, 6)
        self.assertGreater(remote, 30, "the server is used again")
        self.assertIn("local.onnx answers: the result of the model is lost", done.stderr)
        self.assertIn("the model answers again; the fallback", done.stderr)
        self.assertRegex(done.stderr, r"requests: 60 sent = \d+ answered \+ 0 late \+ 0 refused \+ \d+ lost")

    def who_answered(self, line):
        done = subprocess.run(["/usr/bin/python3", "-c", WHO_ANSWERED, line.replace("! filesink", "! identity name=end ! filesink")],
                              capture_output=True, text=True, timeout=120, env={**os.environ, "GST_DEBUG": "1", "GST_TRACERS": ""})
        if "import gi" in done.stderr:
            self.skipTest("python3-gi is missing")
        self.assertEqual(done.returncode, 0, done.stderr)
        *frames, end = done.stdout.splitlines()
        self.assertEqual(end, "end")
        return [frame.removeprefix("WeirAnsweredBy, ").removesuffix(";") for frame in frames]

    def test_a_meta_says_who_answered_each_frame(self):
        _, first = self.server("--away", "10:6")
        local = self.local_model()
        line = self.line(first, f"name=f fallback={local} custom=probe-ms:20,attempts:1,in-flight:1", self.frames)
        who = self.who_answered(line)
        remote, fallback = self.answers()
        self.assertEqual(who.count(f'f=(string){first}'), remote)
        self.assertEqual(who.count(f'f=(string){local}'), fallback)
        self.assertEqual((remote + fallback, fallback > 0), (FRAMES, True))

    def test_the_meta_has_a_field_for_each_filter(self):
        _, one = self.server()
        _, two = self.server()
        line = self.line(one, f"name=f batch-size=4 ! tensor_filter name=g framework=oip model={two}", self.frames)
        self.assertEqual(self.who_answered(line), [f"f=(string){one}, g=(string){two}"] * FRAMES)

    def test_a_fallback_answers_when_no_server_is_there_at_the_start(self):
        process, model = self.server()
        process.kill()
        process.wait()
        done = self.play(model, f"fallback={self.local_model()}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.answers(), (0, FRAMES))

    def test_a_fallback_answers_within_the_deadline_when_the_server_is_slow(self):
        _, model = self.server("--delay", "4")
        done = self.play(model, f"fallback={self.local_model()} deadline=2000000000 custom=in-flight:64,attempts:1",
                         before="identity sync=true ! ")  # without a clock, frames have no deadline
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.answers(), (0, FRAMES))

    def test_batches_end_with_their_deadline_when_the_server_is_slow(self):
        _, model = self.server("--delay", "4")
        line = self.line(model, "name=remote batch-size=4 deadline=1000000000 custom=attempts:1", self.frames, before="identity sync=true ! ")
        done = self.weir_run(line, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        stats = next(one["stats"] for one in json.loads(done.stdout)["ledger"] if one["name"] == "remote")
        self.assertEqual((stats["pushed"], stats["dropped"]), (0, FRAMES), stats)

    def test_a_fallback_of_another_shape_is_refused_at_the_start(self):
        _, model = self.server()
        done = self.play(model, f"fallback={self.local_model(width=5)}")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("the fallback has other tensors than the model", done.stderr)
        self.assertIn("inputs 1 tensor: float32 5:?; outputs 1 tensor: float32 5:?", done.stderr)
        self.assertIn("needed: inputs 1 tensor: float32 4:?; outputs 1 tensor: float32 4:?", done.stderr)

    def test_a_pipeline_stops_in_every_state_of_its_server(self):
        """Each with a request in flight or waiting, interrupted as by Ctrl-C."""
        frames = np.zeros((2000, 4), np.float32)
        slow, stopped, killed = (self.server("--print-times", "--delay", "0.2") for _ in range(3))
        cases = ((slow, None, ""), (stopped, signal.SIGSTOP, ""), (killed, signal.SIGKILL, ""),
                 (self.server("--print-times"), signal.SIGSTOP, "fallback"))
        for (process, model), sent, local in cases:
            options = "custom=timeout-ms:1000 ! identity sync=true"
            if local:
                options = f"fallback={self.local_model()} {options}"
            line = self.line(model, options, frames)
            with subprocess.Popen(["gst-launch-1.0", *line.split()], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True, env={**os.environ, "GST_DEBUG": "1", "GST_TRACERS": ""}) as launched:
                self.assertIn("left ", process.stdout.readline(), "no request arrived")
                if sent:
                    process.send_signal(sent)
                interrupt(launched)
                try:
                    errors = launched.communicate(timeout=30)[1]
                finally:
                    launched.kill()
            if sent == signal.SIGSTOP:
                process.send_signal(signal.SIGCONT)
            self.assertNotIn("CRITICAL", errors)
            self.assertNotIn("WEIR-", errors)
            self.assertGreaterEqual(launched.returncode, 0, errors)

    def test_the_log_adds_up_the_requests(self):
        _, model = self.server()
        done = self.play(model, debug="weir-oip:4")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, rf"INFO +weir-oip .*requests: {FRAMES} sent = {FRAMES} answered \+ 0 late \+ 0 refused \+ 0 lost")

    def weir_run(self, line, *options):
        return subprocess.run([os.environ["WEIR_COMMAND"], "run", *options, line], capture_output=True, text=True, timeout=120,
                              env={**os.environ, "GST_DEBUG": "1", "GST_TRACERS": ""})

    def test_the_figures_of_each_server(self):
        _, timed = self.server("--times", "7200")
        _, foreign = self.server()  # refuses requests with parameters
        line = self.line(f"{timed},{foreign}", "name=remote custom=in-flight:1", self.frames)
        done = self.weir_run(line, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        stats = next(one["stats"] for one in json.loads(done.stdout)["ledger"] if one["name"] == "remote")
        self.assertEqual([one["address"] for one in stats["servers"]], [timed, foreign])
        for end in ("answered", "late", "refused", "lost"):
            self.assertEqual(sum(one[end] for one in stats["servers"]), FRAMES if end == "answered" else 0)
        self.assertEqual([one["circuit"] for one in stats["servers"]], ["closed", "closed"])
        ours, theirs = stats["servers"]
        self.assertLessEqual(abs(ours["clock-offset-ns"] - 7200 * 10**9), ours["clock-error-ns"])
        self.assertEqual((ours["queue-us"], ours["compute-us"]), (1500, 2500))
        for name in ("clock-offset-ns", "clock-error-ns", "queue-us", "compute-us"):
            self.assertNotIn(name, theirs)

    def test_the_figures_of_each_server_as_text_and_on_the_page(self):
        _, lost = self.server("--away", "0:2")
        _, used = self.server("--times", "3600")
        done = self.weir_run(self.line(f"{lost},{used}", "name=remote custom=in-flight:1,probe-ms:60000", self.frames), "--report", f"{self.folder}/page.html")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"Servers\n  filter +server +answered +late +refused +lost +in flight +circuit +p50 ms")
        self.assertRegex(done.stdout, rf"remote +{lost} +0 +0 +0 +2 +0 +open +- ")
        self.assertRegex(done.stdout, rf"remote +{used} +20 +0 +0 +0 +0 +closed .* 1\.5 +2\.5 .* 3600000\.\d ")
        page = (self.folder / "page.html").read_text()
        self.assertRegex(page, rf"<h2>Servers</h2>[^$]*{lost}[^$]*{used}")

    def test_no_servers_without_requests_to_any(self):
        done = self.weir_run("videotestsrc num-buffers=1 ! tensor_converter ! fakesink")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("Servers", done.stdout)

    def test_a_second_server_answers_for_one_that_does_not(self):
        (dead, first), (_, second) = self.server(), self.server()
        dead.kill()
        dead.wait()
        done = self.play(f"{first},{second}")
        self.assertEqual(done.returncode, 0, done.stderr)
        np.testing.assert_allclose(self.result(), 2 * self.frames + 1, rtol=1e-6)

    def test_another_type_is_refused_before_it_is_sent(self):
        _, model = self.server()
        done = self.play(model, data=np.arange(8, dtype=np.int32).reshape(2, 4), data_type="int32")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-2001: the stream does not fit the model\n  offered: 1 tensor: int32 4:1", done.stderr)
        self.assertIn("needed: 1 tensor: float32", done.stderr)

    def test_no_server_is_an_error_at_the_start(self):
        process, model = self.server()
        process.kill()
        process.wait()
        done = self.play(model)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-6001", done.stderr)
        self.assertIn(model.split("/")[2], done.stderr)

    def test_another_machine_without_tls_is_an_error(self):
        done = self.play("grpc://192.0.2.1:8001/affine/1")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-6003", done.stderr)
        self.assertIn("grpcs://", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
