#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir try --show on a display of Xvfb: the window comes, and closing it ends the run."""

import ctypes
import os
import select
import shutil
import subprocess
import unittest

import numpy
import onnx_writer
import tap_runner
from weir_case import COMMAND, HAS_ONNX, SANITIZED, SOURCE, Case

XVFB = shutil.which("Xvfb")
SUBSTRUCTURE_NOTIFY, MAP_NOTIFY, CLIENT_MESSAGE = 1 << 19, 19, 33  # X.h


class Event(ctypes.Structure):
    """XMapEvent and XClientMessageEvent begin alike; an XEvent has 24 longs."""

    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("is_sent", ctypes.c_int), ("display", ctypes.c_void_p),
                ("parent", ctypes.c_ulong), ("window", ctypes.c_ulong), ("format", ctypes.c_int), ("values", ctypes.c_long * 5),
                ("rest", ctypes.c_long * 24)]


class Display:
    """A client that does what a window manager does when a user closes a window."""

    def __init__(self, name):
        self.x11 = ctypes.CDLL("libX11.so.6")
        for function in ("XOpenDisplay", "XDefaultRootWindow", "XInternAtom"):
            getattr(self.x11, function).restype = ctypes.c_void_p
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(name.encode()))
        root = ctypes.c_void_p(self.x11.XDefaultRootWindow(self.display))
        self.x11.XSelectInput(self.display, root, ctypes.c_long(SUBSTRUCTURE_NOTIFY))
        self.x11.XSync(self.display, 0)

    def next_window(self, seconds):
        """The next window that is shown; None if none is within the time."""
        event = Event()
        while True:
            if not self.x11.XPending(self.display) and not select.select([self.x11.XConnectionNumber(self.display)], [], [], seconds)[0]:
                return None
            self.x11.XNextEvent(self.display, ctypes.byref(event))
            if event.type == MAP_NOTIFY:
                return event.window

    def close_window(self, window):
        atom = lambda name: self.x11.XInternAtom(self.display, name, 0)  # noqa: E731
        event = Event(type=CLIENT_MESSAGE, parent=window, window=atom(b"WM_PROTOCOLS"), format=32)
        event.values[0] = atom(b"WM_DELETE_WINDOW")
        self.x11.XSendEvent(self.display, ctypes.c_ulong(window), 0, ctypes.c_long(0), ctypes.byref(event))
        self.x11.XSync(self.display, 0)

    def disconnect(self):
        self.x11.XCloseDisplay(self.display)


@unittest.skipUnless(XVFB and HAS_ONNX and not SANITIZED, "needs Xvfb and the engine onnxruntime")
class Shown(Case):
    def setUp(self):
        super().setUp()
        read, write = os.pipe()
        server = subprocess.Popen([XVFB, "-displayfd", str(write), "-screen", "0", "320x240x24", "-nolisten", "tcp"], pass_fds=[write],
                                  stderr=subprocess.DEVNULL)
        os.close(write)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        with os.fdopen(read) as numbers:
            self.name = ":" + numbers.readline().strip()
        self.display = Display(self.name)
        self.addCleanup(self.display.disconnect)

    def started(self, name, *options):
        path = self.folder / "depth.onnx"
        path.write_bytes(onnx_writer.model([("Conv", ("image", "w"), "depth")], {"w": numpy.full((1, 3, 1, 1), 1 / 3, "f")},
                                           [("image", (1, 3, 96, 96))], [("depth", (1, 1, 96, 96))]))
        environment = {**os.environ, "DISPLAY": self.name, "WAYLAND_DISPLAY": "", "GST_PLUGIN_FEATURE_RANK": "ximagesink:MAX"}
        process = subprocess.Popen([COMMAND, "try", path, name, "--show", *options], env=environment, cwd=SOURCE, text=True,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        return process

    def ends_when_closed(self, process):
        window = self.display.next_window(60)
        self.assertIsNotNone(window, "no window was shown")
        self.display.close_window(window)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, err)
        self.assertNotIn("warning", err)
        return out

    def test_a_photo_stays_until_its_window_is_closed(self):
        from PIL import Image
        photo = self.folder / "white.png"
        Image.new("RGB", (64, 64), "white").save(photo)
        process = self.started(photo)
        for line in process.stdout:
            if line.startswith("  depth"):
                break
        with self.assertRaises(subprocess.TimeoutExpired):
            process.wait(timeout=1)
        self.ends_when_closed(process)

    def test_closing_the_window_ends_a_video_and_its_file(self):
        output = self.folder / "shown.mkv"
        self.assertIn("depth", self.ends_when_closed(self.started("test", "--output", output)))
        self.runs(f"gst-launch-1.0 -q filesrc location={output} ! matroskademux ! jpegdec ! fakesink")

    def test_a_video_ends_without_being_closed(self):
        process = self.started("test")
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, err)
        self.assertEqual(out.count("  depth"), 100)


if __name__ == "__main__":
    tap_runner.main()
