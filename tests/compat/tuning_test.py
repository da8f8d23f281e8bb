#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests a Python program that changes properties through GObject introspection while its pipelines play."""

import os
import subprocess
import sys
import unittest

import tap_runner

SOURCE = "videotestsrc pattern=white ! video/x-raw,format=RGB,width=4,height=2,framerate=30/1 ! "
TENSORS = SOURCE + "tensor_converter ! "
# Pipeline, property, value, whether it is accepted.
TUNINGS = [
    (TENSORS + "tensor_transform name=it mode=arithmetic option=add:1", "option", "add:2", True),
    (TENSORS + "tensor_transform name=it mode=arithmetic option=add:1", "option", "add:x", False),
    (TENSORS + "tensor_transform name=it mode=arithmetic option=add:1", "acceleration", False, True),
    (TENSORS + "tensor_aggregator name=it frames-out=2 frames-dim=3", "frames-out", 4, True),
    (TENSORS + "tensor_aggregator name=it frames-out=2 frames-dim=3", "concat", False, True),
    (SOURCE + "tensor_converter name=it", "frames-per-tensor", 3, True),
    (SOURCE + "tensor_converter name=it", "set-timestamp", False, True),
    (TENSORS + "tensor_demux name=it tensorpick=0 it.src_0", "tensorpick", "0,0", True),
    (TENSORS + "tensor_demux name=it tensorpick=0 it.src_0", "tensorpick", "one", False),
    (TENSORS + "tensor_split name=it tensorseg=3:4:1,3:4:1 it.src_0", "tensorseg", "3:2,3:6", True),
    (TENSORS + "tensor_split name=it tensorseg=3:4:1,3:4:1 it.src_0", "split-parts", 2, False),
    (TENSORS + "tensor_merge name=it", "option", "2", True),
    (TENSORS + "tensor_merge name=it", "option", "two", False),
    (TENSORS + "tensor_transform name=it mode=typecast option=float32", "silent", False, True),
]


class Program:
    """A playing pipeline that counts its frames."""

    def __init__(self, gst, line):
        self.gst = gst
        self.pipeline = gst.parse_launch(line + " ! appsink name=out sync=false max-buffers=1")
        self.element = self.pipeline.get_by_name("it")
        self.sink = self.pipeline.get_by_name("out")
        self.pipeline.set_state(gst.State.PLAYING)

    def pull(self):
        return self.sink.emit("try-pull-sample", 60 * self.gst.SECOND)

    def messages(self, kind):
        bus, out = self.pipeline.get_bus(), []
        while message := bus.pop_filtered(self.gst.MessageType.ERROR | self.gst.MessageType.WARNING):
            parse = message.parse_warning if message.type == self.gst.MessageType.WARNING else message.parse_error
            out.append((message.type, parse()[0].message))
        return [text for type_, text in out if type_ == kind]

    def stop(self):
        self.pipeline.set_state(self.gst.State.NULL)


class Tuning(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        import gi
        gi.require_version("Gst", "1.0")
        from gi.repository import Gst
        Gst.init(None)
        cls.gst = Gst

    def play(self, line):
        program = Program(self.gst, line)
        self.addCleanup(program.stop)
        return program

    def test_each_property_is_taken_or_refused_with_a_warning(self):
        for line, name, value, taken in TUNINGS:
            with self.subTest(f"{name}={value}: {line}"):
                program = self.play(line)
                self.assertIsNotNone(program.pull())
                before = program.element.get_property(name)
                program.element.set_property(name, value)
                for _ in range(4):
                    self.assertIsNotNone(program.pull(), "the stream goes on")
                warnings = program.messages(self.gst.MessageType.WARNING)
                self.assertEqual(program.element.get_property(name), value if taken else before)
                self.assertEqual(bool(warnings), not taken, warnings)
                program.stop()

    def test_another_type_comes_with_other_caps(self):
        program = self.play(TENSORS + "tensor_transform name=it mode=typecast option=int16")
        self.assertEqual(program.pull().get_buffer().get_size(), 2 * 24)
        program.element.set_property("option", "float64")
        for _ in range(4):
            sample = program.pull()
        self.assertEqual(sample.get_buffer().get_size(), 8 * 24)
        self.assertIn("float64", sample.get_caps().to_string())

    def test_a_transform_plays_without_a_mode(self):
        program = self.play("appsrc name=in format=time caps=other/tensor,dimension=(string)2,type=(string)uint8,"
                            "framerate=(fraction)30/1 ! tensor_transform name=it")
        program.element.set_property("mode", 2)
        program.element.set_property("option", "add:1")
        program.pipeline.get_by_name("in").emit("push-buffer", self.gst.Buffer.new_wrapped(b"\x01\x02"))
        buffer = program.pull().get_buffer()
        self.assertEqual(buffer.extract_dup(0, 2), b"\x02\x03")


if __name__ == "__main__":
    lacking = subprocess.run([sys.executable, "-c", "import gi; gi.require_version('Gst', '1.0')"], check=False,
                             capture_output=True, env=os.environ).returncode
    if lacking:
        print("1..0 # SKIP GObject introspection of GStreamer is not there")
        sys.exit(0)
    tap_runner.main()
