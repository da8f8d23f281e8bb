#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ctrl-C ends the calls of the package weir that wait: in programs of their own, which get the signal."""

import subprocess
import sys
import unittest

import tap_runner

try:
    import weir  # noqa: F401: only whether it can be imported
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

# The tenth frame of a live source sends the signal: the main thread waits by then.
PROGRAM = """
import os, signal, sys, threading
import weir

frames = []
def interrupt(frame):
    frames.append(frame)
    if len(frames) == 10:
        assert threading.current_thread() is not threading.main_thread()
        os.kill(os.getpid(), signal.SIGINT)

text = ("videotestsrc is-live=true pattern=black ! video/x-raw,format=GRAY8,width=4,height=4,framerate=100/1 ! appsink name=live "
        "sync=false appsrc name=in ! appsink name=silent async=false")
pipeline = weir.Pipeline(text)
pipeline.on_frame("live", interrupt)
handled = []
if "handler" in sys.argv:
    signal.signal(signal.SIGINT, lambda *_: (handled.append(1), pipeline.end("in")))
with pipeline:
    try:
        got = {call}
        print("returned", got, handled)
    except KeyboardInterrupt:
        print("interrupted")
print(pipeline.state)
"""


def output_of(call, *arguments):
    done = subprocess.run([sys.executable, "-c", PROGRAM.replace("{call}", call), *arguments], capture_output=True, text=True,
                          timeout=60, check=False)
    return done.stdout.splitlines() or [done.stderr]


class Interrupt(unittest.TestCase):
    def test_ends_wait(self):
        for call in ("pipeline.wait()", "pipeline.wait(timeout=50)"):
            with self.subTest(call=call):
                self.assertEqual(output_of(call), ["interrupted", "stopped"])

    def test_ends_pull(self):
        for call in ("pipeline.pull('silent')", "pipeline.pull('silent', timeout=50)"):
            with self.subTest(call=call):
                self.assertEqual(output_of(call), ["interrupted", "stopped"])

    def test_a_handler_that_returns_does_not(self):
        # The handler ends the stream of the sink, so that pull() returns without a frame.
        self.assertEqual(output_of("pipeline.pull('silent', timeout=50)", "handler"), ["returned None [1]", "stopped"])


class TimeLimits(unittest.TestCase):
    def test_are_kept_without_a_signal(self):
        with weir.Pipeline("appsrc name=in ! tensor_sink name=out async=false") as pipeline:
            for call in (pipeline.wait, lambda timeout: pipeline.pull("out", timeout) is not None):
                for timeout in (0, 0.02, 0.12):
                    self.assertIs(call(timeout=timeout), False)


if __name__ == "__main__":
    tap_runner.main()
