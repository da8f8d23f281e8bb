#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir run` beside a person or service manager: reports to systemd, hints after a crash, colours."""

import os
import pty
import re
import select
import signal
import socket
import subprocess
import threading
import unittest

import tap_runner
from weir_case import COMMAND, SANITIZED, Case, weir


class Service(Case):
    PIPELINE = "videotestsrc num-buffers=7 ! tensor_converter ! tensor_sink name=out"

    def interrupted(self, running):
        output, errors = running.communicate(timeout=30)
        self.assertEqual(running.returncode, 130, output + errors)
        return output, errors

    def crash(self, *options):
        """Runs a filter that crashes when it is opened; the output, and the line before the last word."""
        model = self.folder / "model"
        model.write_text("any")
        line = ("videotestsrc num-buffers=1 ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! "
                f"tensor_filter name=f framework=unruly model={model} custom=open:")
        return weir("run", *options, line + "crash ! fakesink"), line

    @unittest.skipIf(SANITIZED, "the sanitizer reports the crash")
    def test_a_crash_in_a_filter_comes_with_isolate(self):
        done, line = self.crash("-q")
        self.assertEqual(done.returncode, -signal.SIGSEGV, done.stderr)
        isolated = line.replace("tensor_filter ", "tensor_filter isolate=process ")
        self.assertEqual(done.stdout, "")
        self.assertIn("error: the process crashed, perhaps in the model or filter of f\n  needed: isolate=process", done.stderr)
        self.assertIn(f"\n  fix: {isolated}crash ! fakesink\n", done.stderr)

    def test_an_error_that_is_no_crash_has_no_such_hint(self):
        model = self.folder / "model"
        model.write_text("any")
        done = weir("run", f"fakesrc num-buffers=1 ! tensor_filter framework=unruly model={model} custom=open:throw ! fakesink")
        self.assertEqual(done.returncode, 1)
        self.assertNotIn("the process crashed", done.stderr)

    def colours(self, *words, **variables):
        """What a command prints on a terminal."""
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        env = {**os.environ, "TERM": "xterm", **variables}
        running = subprocess.Popen([COMMAND, *words], stdout=theirs, stderr=theirs, env=env)
        os.close(theirs)
        seen = b""
        while running.poll() is None or select.select([ours], [], [], 0)[0]:
            try:
                seen += os.read(ours, 65536)
            except OSError:  # the other side is closed
                break
        running.wait(timeout=30)
        return seen.decode().replace("\r\n", "\n")

    def test_errors_on_a_terminal_are_in_colour_and_no_color_is_respected(self):
        line = ("run", "videotestsrc ! tensor_convertr ! fakesink")
        seen = self.colours(*line, NO_COLOR="")
        self.assertIn("\033[1;31mWEIR-1001: the element tensor_convertr is not installed\033[0m\n", seen)
        self.assertIn("\033[32m  fix: videotestsrc ! tensor_converter ! fakesink\033[0m\n", seen)
        plain = weir(*line).stderr
        self.assertNotIn("\033", plain, "no terminal")
        for variables in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
            self.assertEqual(self.colours(*line, **variables), plain)
        failed = self.colours("run", "-q", "videotestsrc ! identity name=weak error-after=2 ! fakesink", NO_COLOR="")
        self.assertIn("\033[1;31merror from weak\033[0m: ", failed)

    def service(self, address, **variables):
        """A socket of a service manager, and a function that starts `weir run --service` with it."""
        manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(manager.close)
        manager.bind(address.replace("@", "\0"))
        manager.settimeout(30)
        env = {**os.environ, "NOTIFY_SOCKET": address, **variables}

        def start(*words):
            return subprocess.Popen([COMMAND, "run", "--service", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
        return manager, start

    def test_a_service_reports_that_it_plays_and_stops(self):
        for address in (str(self.folder / "notify"), f"@weir-{os.getpid()}"):
            manager, start = self.service(address)
            running = start("videotestsrc is-live=true ! fakesink")
            self.assertEqual(manager.recv(1000), b"READY=1\nSTATUS=playing")
            running.send_signal(signal.SIGTERM)
            self.assertEqual(manager.recv(1000), b"STOPPING=1")
            self.interrupted(running)

    def test_a_service_feeds_its_watchdog(self):
        manager, start = self.service(str(self.folder / "notify"), WATCHDOG_USEC="40000", WATCHDOG_PID="")
        running = start("videotestsrc is-live=true ! fakesink")
        self.assertEqual([manager.recv(1000) for _ in range(4)], [b"READY=1\nSTATUS=playing"] + 3 * [b"WATCHDOG=1"])
        running.send_signal(signal.SIGTERM)
        self.interrupted(running)
        manager, start = self.service(str(self.folder / "other"), WATCHDOG_USEC="40000", WATCHDOG_PID="1")
        self.assertEqual(start("videotestsrc num-buffers=20 is-live=true ! fakesink").wait(timeout=30), 0)
        self.assertEqual([manager.recv(1000), manager.recv(1000)], [b"READY=1\nSTATUS=playing", b"STOPPING=1"], "that of another process")

    def test_a_camera_that_delivers_nothing_does_not_feed_the_watchdog(self):
        manager, start = self.service(str(self.folder / "notify"), WATCHDOG_USEC="1000000", WATCHDOG_PID="")
        running = start("-v", "udpsrc address=127.0.0.1 port=0 name=camera caps=application/x-rtp,media=video,clock-rate=90000 ! fakesink")
        self.addCleanup(running.kill)
        port = int(next(filter(None, (re.match(r"camera: port = (\d+)", line) for line in running.stderr)))[1])
        sends, ends = threading.Event(), threading.Event()

        def send():
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as camera:
                while not ends.wait(0.02):
                    if sends.is_set():
                        camera.sendto(bytes(20), ("127.0.0.1", port))
        sends.set()
        camera = threading.Thread(target=send)
        camera.start()
        self.addCleanup(camera.join)
        self.addCleanup(ends.set)
        self.assertEqual([manager.recv(1000) for _ in range(5)], [b"READY=1\nSTATUS=playing"] + 4 * [b"WATCHDOG=1"])
        sends.clear()
        self.assertIn("camera delivered nothing for 1 s: the watchdog is not fed until it does\n",
                      iter(running.stderr.readline, ""))
        manager.setblocking(False)
        with self.assertRaises(BlockingIOError):
            while manager.recv(1000) == b"WATCHDOG=1":
                pass
        manager.settimeout(2)
        self.assertRaises(TimeoutError, manager.recv, 1000)
        sends.set()
        manager.settimeout(30)
        self.assertEqual(manager.recv(1000), b"WATCHDOG=1")
        running.send_signal(signal.SIGTERM)
        running.stderr.read()
        self.assertEqual(running.wait(timeout=30), 130)

    def test_a_camera_that_ended_beside_others_does_not_feed_the_watchdog(self):
        manager, start = self.service(str(self.folder / "notify"), WATCHDOG_USEC="1000000", WATCHDOG_PID="")
        running = start("videotestsrc is-live=true ! fakesink videotestsrc name=short is-live=true num-buffers=2 ! fakesink")
        self.addCleanup(running.kill)
        self.assertIn("short delivered nothing for 1 s", running.stderr.readline())
        running.send_signal(signal.SIGTERM)
        self.interrupted(running)

    def test_other_sources_may_rest(self):
        # A file that is read at once, messages, and a camera whose caps allow one picture in four seconds.
        manager, start = self.service(str(self.folder / "notify"), WATCHDOG_USEC="1000000", WATCHDOG_PID="")
        running = start("videotestsrc num-buffers=2 ! fakesink udpsrc address=127.0.0.1 port=0 caps=application/x-rtp,media=application ! "
                        "fakesink async=false videotestsrc is-live=true ! video/x-raw,framerate=1/4 ! fakesink")
        self.addCleanup(running.kill)
        self.assertEqual([manager.recv(1000) for _ in range(7)], [b"READY=1\nSTATUS=playing"] + 6 * [b"WATCHDOG=1"])
        running.send_signal(signal.SIGTERM)
        self.assertNotIn("delivered nothing", self.interrupted(running)[1])

    def test_a_service_that_does_not_start_is_not_ready(self):
        manager, start = self.service(str(self.folder / "notify"))
        self.assertEqual(start("filesrc location=/nowhere ! fakesink").wait(timeout=30), 1)
        self.assertEqual(manager.recv(1000), b"STOPPING=1", "it was never ready")

    def test_a_service_without_its_manager(self):
        self.good(weir("run", "--service", self.PIPELINE))
        for address in ("/nowhere/notify", "notify", "/" + "a" * 200):
            self.refused(weir("run", "--service", self.PIPELINE, NOTIFY_SOCKET=address), 1,
                         "WEIR-6001: the service manager cannot be reached", f"offered: NOTIFY_SOCKET={address}: ",
                         "needed: a socket of systemd")


if __name__ == "__main__":
    tap_runner.main()
