#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir run --clock` and `--serve-clock`: the stated error holds, also where the monotonic clocks differ."""

import json
import re
import shutil
import socket
import struct
import subprocess
import threading
import time

import tap_runner
from weir_case import COMMAND, Case, weir

LIVE = "videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=16,height=16 ! fakesink"
SHIFT = 1000  # seconds
SHIFTED = ["unshare", "--time", "--monotonic", str(SHIFT), "--fork", "--kill-child"]
NTP_OF_1970 = 2_208_988_800
SECOND = 1_000_000_000


def can_shift():
    return shutil.which("unshare") and subprocess.run([*SHIFTED, "true"], capture_output=True, check=False).returncode == 0


class NtpServer:
    """Answers with the monotonic clock plus a constant, in the format of RFC 5905."""

    AHEAD = NTP_OF_1970 + 1_700_000_000

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.thread = threading.Thread(target=self.answer)
        self.thread.start()

    def now(self):
        seconds, rest = divmod(time.monotonic_ns(), SECOND)
        return struct.pack("!II", seconds + self.AHEAD, (rest << 32) // SECOND)

    def answer(self):
        while (received := self.socket.recvfrom(100))[0] != b"stop":
            request, peer = received
            arrived = self.now()
            head = struct.pack("!BBbbII4s", 0o44, 1, 4, -20, 0, 0, b"TEST")
            self.socket.sendto(head + arrived + request[40:48] + arrived + self.now(), peer)

    def stop(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
            one.sendto(b"stop", ("127.0.0.1", self.port))
        self.thread.join()
        self.socket.close()


class Clock(Case):
    def serve(self, *before):
        """The port of a clock that is served until the end of the test."""
        server = subprocess.Popen([*before, COMMAND, "run", "--serve-clock", "0", LIVE], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                  stdin=subprocess.DEVNULL, text=True)
        self.addCleanup(server.stderr.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        line = server.stderr.readline()
        found = re.fullmatch(r"Clock served on port (\d+)\n", line)
        self.assertTrue(found, line)
        return int(found[1])

    def state(self, address):
        report = json.loads(self.good(self.run_for(0.5, "--json", "--clock", address, LIVE)))
        self.assertEqual(report["errors"], [])
        return report["clock"]

    def holds(self, clock, offset):
        self.assertGreaterEqual(clock["error_ns"], clock["round_trip_ns"] // 2)
        self.assertLess(clock["error_ns"], SECOND)
        self.assertLessEqual(abs(clock["offset_ns"] - offset), clock["error_ns"])
        print(f"# off by {clock['offset_ns'] - offset} ns, at most {clock['error_ns']} ns stated")

    def test_the_stated_error_holds(self):
        self.holds(self.state(f"net://127.0.0.1:{self.serve()}"), 0)

    def test_the_stated_error_holds_for_a_shifted_clock(self):
        if not can_shift():
            self.skipTest("time namespaces are not permitted here")
        self.holds(self.state(f"net://127.0.0.1:{self.serve(*SHIFTED)}"), SHIFT * SECOND)

    def test_the_time_of_an_ntp_server(self):
        server = NtpServer()
        self.addCleanup(server.stop)
        self.holds(self.state(f"ntp://127.0.0.1:{server.port}"), server.AHEAD * SECOND)

    def test_a_live_source_has_the_time_of_the_clock(self):
        before = time.monotonic_ns()
        done = self.run_for(0.5, "-v", "--serve-clock", "0", "videotestsrc is-live=true num-buffers=1 ! identity silent=false ! fakesink")
        self.good(done)
        hours, minutes, seconds = re.search(r"pts:\\? (\d+):(\d+):([\d.]+)", done.stderr).groups()
        pts = (int(hours) * 60 + int(minutes)) * 60 * SECOND + round(float(seconds) * SECOND)
        self.assertLess(before, pts)
        self.assertLess(pts, time.monotonic_ns())

    def test_addresses_that_cannot_be_read(self):
        for address in ("camera:5637", "http://camera:1", "net://camera", "net://:5", "net://a:70000", "ntp://", "ptp://x", "ptp://256", ""):
            done = weir("run", "--clock", address, LIVE) if address else weir("run", "--clock")
            self.assertNotEqual(done.returncode, 0, address)
            if address:
                self.assertIn(f"WEIR-1004: the address of a clock cannot be read\n  offered: --clock {address}\n", done.stderr)
                self.assertIn("needed: net://HOST:PORT, ntp://HOST, ntp://HOST:PORT or ptp://DOMAIN", done.stderr)

    def test_a_clock_that_does_not_answer(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
            silent.bind(("127.0.0.1", 0))
            done = weir("run", "--clock", f"net://127.0.0.1:{silent.getsockname()[1]}", LIVE)
            self.assertEqual(done.returncode, 1)
            self.assertIn("WEIR-6001: the clock did not synchronise within 10 seconds", done.stderr)
            self.assertIn("fix: weir run --serve-clock 5637 PIPELINE, on that machine", done.stderr)

    def test_a_port_that_is_taken(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("0.0.0.0", 0))
            done = weir("run", "--serve-clock", str(other.getsockname()[1]), LIVE)
            self.assertEqual(done.returncode, 1)
            self.assertIn("WEIR-1004: the clock cannot be served", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
