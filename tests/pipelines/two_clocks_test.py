#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Streams of two devices, muxed by their times: the monotonic clock of one is ahead, and it starts later."""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

import numpy as np

import mqtt_broker
import tap_runner
from built_modules import has_engine

SHIFTED = ["unshare", "--time", "--monotonic", "1000", "--fork", "--kill-child"]
RATE = 10
PAIRS = 20
# Each frame becomes the wall clock's time at which it was made: both devices read the same one.
NOW = """
import time
import numpy as np
from weir import TensorShape
class CustomFilter:
    def getInputDim(self):
        return [TensorShape([1, 8, 1, 1], np.uint8)]
    def getOutputDim(self):
        return [TensorShape([1], np.float64)]
    def invoke(self, inputs):
        return [np.array([time.time()])]
"""


def can_shift():
    return shutil.which("unshare") and subprocess.run([*SHIFTED, "true"], capture_output=True, check=False).returncode == 0


@unittest.skipUnless(mqtt_broker.find_mosquitto() and shutil.which("mosquitto_sub"), "mosquitto is not installed, or this build has no MQTT")
@unittest.skipUnless(has_engine("python3"), "the engine python3 is not built")
class TwoClocks(unittest.TestCase):
    def setUp(self):
        if not can_shift():
            self.skipTest("time namespaces are not permitted here")
        cleanups = contextlib.ExitStack()
        self.addCleanup(cleanups.close)
        self.port = cleanups.enter_context(mqtt_broker.running_broker())
        self.folder = pathlib.Path(cleanups.enter_context(tempfile.TemporaryDirectory()))
        (self.folder / "now.py").write_text(NOW)

    def start(self, line, *before):
        process = subprocess.Popen([*before, "gst-launch-1.0", "-q", "-e", *line.split()], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                   start_new_session=True, env={**os.environ, "GST_TRACERS": "", "GST_DEBUG": ""})
        for undo in (process.stderr.close, process.wait, process.kill):
            self.addCleanup(undo)
        return process

    def device(self, topic, protocol, *before):
        return self.start(f"videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=8,height=1,framerate={RATE}/1 ! tensor_converter ! "
                          f"tensor_filter framework=python3 model={self.folder}/now.py ! mqttsink protocol={protocol} port={self.port} pub-topic={topic}",
                          *before)

    def await_messages(self, topic, count):
        done = subprocess.run(["mosquitto_sub", "-p", str(self.port), "-t", topic, "-C", str(count), "-W", "60"], capture_output=True, check=False)
        self.assertEqual(done.returncode, 0, f"{count} messages of {topic} have not come")

    def pairs(self, protocol):
        """The times in the frames of both devices that tensor_mux put together."""
        (self.folder / "pairs").write_bytes(b"")
        first = self.device("first", protocol)
        self.await_messages("first", RATE)  # a second's
        second = self.device("second", protocol, *SHIFTED)
        muxed = self.start(f"tensor_mux name=m sync-mode=slowest ! filesink buffer-mode=unbuffered location={self.folder}/pairs "
                           f"mqttsrc protocol={protocol} port={self.port} sub-topic=first ! m.sink_0 "
                           f"mqttsrc protocol={protocol} port={self.port} sub-topic=second ! m.sink_1")
        while (self.folder / "pairs").stat().st_size < 16 * PAIRS:
            self.await_messages("second", 1)
            self.assertIsNone(muxed.poll(), "the muxing pipeline ended")
        for process in (muxed, first, second):
            os.killpg(process.pid, signal.SIGINT)  # unshare passes no signal on
        for process in (muxed, first, second):
            process.wait(60)
        return np.fromfile(self.folder / "pairs", np.float64)[:2 * PAIRS].reshape(-1, 2)

    def test_frames_of_the_same_moment_are_put_together(self):
        for protocol in (4, 5):
            with self.subTest(protocol=protocol):
                pairs = self.pairs(protocol)
                # The nearest frames of two streams are half a frame apart at most; the median, because a busy machine
                # delays single frames.
                apart = np.median(np.abs(pairs[:, 0] - pairs[:, 1]))
                print(f"# {1000 * apart:.1f} ms apart")
                self.assertLess(apart, 0.75 / RATE)
                self.assertTrue(np.all(np.diff(pairs[:, 0]) > 0))


if __name__ == "__main__":
    tap_runner.main()
