#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares lines as NNStreamer's users write them, with every spelling that docs/compatibility allows, with NumPy."""

import os
import pathlib
import re
import shlex
import struct
import subprocess
import tempfile
import unittest

import numpy

import tap_runner

MILLISECOND = 1_000_000
# What identity says of each buffer.
SEEN = re.compile(r"last-message = chain .*?\(seen:sink\) \((\d+) bytes, dts: [^,]+, pts: (none|[\d:.]+), duration: (none|[\d:.]+)")


def nanoseconds(text):
    if text == "none":
        return None
    hours, minutes, seconds, fraction = re.fullmatch(r"(\d+):(\d+):(\d+)\.(\d+)", text).groups()
    return ((int(hours) * 60 + int(minutes)) * 60 + int(seconds)) * 10**9 + int(fraction)


class Buffers:
    """The sizes, times and durations of the buffers that passed `identity name=seen`, and its caps."""

    def __init__(self, text):
        text = text.replace("\\", "")
        found = SEEN.findall(text)
        self.sizes = [int(size) for size, _, _ in found]
        self.times = [nanoseconds(time) for _, time, _ in found]
        self.durations = [nanoseconds(duration) for _, _, duration in found]
        # The event, because GObject may merge notifications of a pad's caps.
        caps = re.findall(r"\(seen:sink\) E \(type: caps .*?caps=\(GstCaps\)\"(.*)\";\)", text)
        self.caps = caps[-1] if caps else ""


class UsersLines(unittest.TestCase):
    def setUp(self):
        self.random = numpy.random.default_rng(20)
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def launch(self, line):
        return subprocess.run(["gst-launch-1.0", "-v", *shlex.split(line.replace("%", str(self.path)))], timeout=120,
                              capture_output=True, text=True, stdin=subprocess.DEVNULL, env=os.environ, check=False)

    def play(self, line):
        done = self.launch(line)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+|CRITICAL")
        return Buffers(done.stdout)

    def play_script(self, line):
        """The same, but skipped where the script's engine is not installed."""
        done = self.launch(line)
        if "WEIR-3002" in done.stderr:
            self.skipTest(done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)

    def read(self, name="out"):
        return (self.path / name).read_bytes()

    def frames(self, name, *shape, element="uint8", high=250):
        """Random frames, also in a file; the first axis counts frames, the last is the innermost dimension."""
        values = self.random.integers(1, high, size=shape).astype(element)
        (self.path / name).write_bytes(values.tobytes())
        return values

    @staticmethod
    def source(name, frame, caps, converter, rate="30/1"):
        return (f"filesrc location=%/{name} blocksize={frame} ! {caps or 'application/octet-stream'},framerate={rate} ! "
                f"tensor_converter {converter} ")

    # ---- tensor_converter --------------------------------------------------------------------

    def test_dots_separate_the_lists_of_bytes(self):
        values = self.frames("in", 4, 22)
        seen = self.play(self.source("in", 22, "", "input-dim=3:2.4 input-type=uint8.float32 silent=TRUE") +
                         "! identity name=seen silent=false ! filesink location=%/out")
        self.assertEqual(self.read(), values.tobytes())
        self.assertRegex(seen.caps, r"num_tensors=\(int\)2, dimensions=\(string\)(\")?3:2,4(\")?")
        self.assertEqual(seen.times, [i * 10**9 // 30 for i in range(4)])

    def test_capsfilters_with_dots_in_both_lists(self):
        values = self.frames("in", 3, 6)
        source = self.source("in", 6, "", "input-dim=2,4 input-type=uint8,uint8")
        for middle in ("", "! tensor_transform mode=clamp option=0:255 ", "! tensor_mux ", "! tensor_demux tensorpick=0:1 name=d d. ",
                       "! other/tensors,format=flexible ! tensor_converter "):
            for lists in ("dimensions=(string)2.4,types=uint8.uint8", "dimensions=2:1.4:1:1,types=(string)'\"UINT8,uint8\"'"):
                with self.subTest(middle + lists):
                    self.play(source + middle + f"! other/tensors,num_tensors=2,format=static,{lists} ! filesink location=%/out")
                    self.assertEqual(self.read(), values.tobytes())

    def test_blanks_and_capitals_of_types_and_dimensions(self):
        values = self.frames("in", 4, 24)
        seen = self.play(self.source("in", 24, "", "input-dim=' 3 : 2 : 1 , 9 ' input-type=' UINT8 , UInt16 '") +
                         "! tensor_demux name=d d.src_1 ! identity name=seen silent=false ! filesink location=%/out")
        self.assertEqual(self.read(), values[:, 6:].tobytes())
        self.assertIn("dimension=(string)9, type=(string)uint16", seen.caps.replace("dimensions", "dimension").replace("types", "type"))

    def test_pictures_with_padded_rows_in_pairs(self):
        self.play("videotestsrc num-buffers=5 pattern=snow ! video/x-raw,format=RGB,width=5,height=3,framerate=15/1 ! "
                  "tee name=t ! queue ! filesink location=%/padded t. ! queue ! tensor_converter frames-per-tensor=2 ! "
                  "identity name=seen silent=false ! filesink location=%/out")
        padded = numpy.frombuffer(self.read("padded"), numpy.uint8).reshape(5, 3, 16)
        self.assertEqual(self.read(), padded[:4, :, :15].tobytes(), "the fifth frame fills no tensor")

    def test_times_of_pictures_in_pairs(self):
        seen = self.play("videotestsrc num-buffers=6 ! video/x-raw,format=GRAY8,width=4,height=4,framerate=10/1 ! "
                         "tensor_converter frames-per-tensor=2 ! identity name=seen silent=false ! "
                         "other/tensors,num_tensors=1,dimensions=1:4:4:2,types=uint8 ! fakesink")
        self.assertEqual(seen.times, [0, 200 * MILLISECOND, 400 * MILLISECOND])
        self.assertEqual(seen.durations, 3 * [200 * MILLISECOND])
        self.assertIn("framerate=(fraction)10/1", seen.caps)

    def test_audio_in_frames_of_ten_milliseconds(self):
        seen = self.play("audiotestsrc num-buffers=4 samplesperbuffer=120 ! audio/x-raw,format=S16LE,rate=8000,channels=2 ! "
                         "tee name=t ! queue ! filesink location=%/samples t. ! queue ! tensor_converter frames-per-tensor=80 ! "
                         "identity name=seen silent=false ! other/tensor,dimension=2:80:1,type=int16,framerate=8000/1 ! "
                         "filesink location=%/out")
        self.assertEqual(self.read(), self.read("samples"))
        self.assertEqual(seen.sizes, 6 * [320])
        self.assertEqual(seen.times, [i * 10 * MILLISECOND for i in range(6)])

    def test_lines_of_text_are_cut_and_filled(self):
        (self.path / "in").write_bytes(b"abcdefghij")
        self.play("filesrc location=%/in blocksize=7 ! text/x-raw,format=utf8 ! tensor_converter input-dim=5 ! "
                  "other/tensors,format=static,num_tensors=1,dimensions=(string)5:1,types=uint8,framerate=0/1 ! filesink location=%/out")
        self.assertEqual(self.read(), b"abcdehij\0\0")

    def test_bytes_for_a_flexible_element_get_headers(self):
        values = self.frames("in", 3, 10)
        self.play(self.source("in", 10, "", "") + "! other/tensors,format=flexible ! filesink location=%/out")
        header = struct.pack("<22I", 0xFEEDCCED, 0xDE001000, 5, 10, *15 * [0], 0, 3, 0).ljust(128, b"\0")
        self.assertEqual(self.read(), b"".join(header + frame.tobytes() for frame in values))

    def test_a_flexible_stream_becomes_static_again(self):
        values = self.frames("in", 3, 4, 4, 3)
        self.play(self.source("in", 48, "", "input-dim=3:4:4 input-type=uint8") +
                  "! other/tensors,format=flexible ! tensor_converter ! other/tensor,dimension=3:4:4:1,type=uint8 ! "
                  "tensor_transform mode=typecast option=int16 ! filesink location=%/out")
        self.assertEqual(self.read(), values.astype("int16").tobytes())

    # ---- tensor_transform --------------------------------------------------------------------

    def test_modes_by_number_and_dimensions_in_short(self):
        values = self.frames("in", 3, 1, 4, 4, 3)
        source = self.source("in", 48, "", "input-dim=3:4:4:1 input-type=uint8")
        lines = {
            "mode=2 option=typecast:float32,add:-127.5,div:127.5 ! other/tensor,dimension=3:4:4,type=float32":
                (values.astype("float32") - numpy.float32(127.5)) / numpy.float32(127.5),
            "mode=0 option=0:2 ! other/tensors,format=static,num_tensors=1,dimensions=4:4:3,types=uint8":
                numpy.moveaxis(values, -1, -3),
            "mode=3 option=1:2:0:3 ! other/tensor,dimension=4:4:3": values.transpose(0, 1, 4, 2, 3),
            "mode=typecast option=FLOAT64": values.astype("float64"),
            "mode=clamp option=50:100.5 acceleration=false": numpy.clip(values, 50, 100),
            "mode=arithmetic option=mul:2,add:-10": numpy.clip(numpy.clip(values.astype(int) * 2, 0, 255) + 246, 0, 255).astype("uint8"),
            "mode=arithmetic option=per-channel:true@0,add:1@0,mul:0@2": self.per_channel(values),
            "mode=padding option=left:1,right:2,top:1,layout:NHWC":
                numpy.pad(values, ((0, 0), (0, 0), (1, 2), (1, 0), (0, 0))),
        }
        for line, expected in lines.items():
            with self.subTest(line):
                self.play(source + f"! tensor_transform {line} ! filesink location=%/out")
                self.assertEqual(self.read(), numpy.ascontiguousarray(expected).tobytes())

    @staticmethod
    def per_channel(values):
        out = values.copy()
        out[..., 0] += 1
        out[..., 2] = 0
        return out

    def test_apply_names_the_tensors(self):
        values = self.frames("in", 3, 8)
        self.play(self.source("in", 8, "", "input-dim=2,2,4 input-type=uint8,uint8,uint8") +
                  "! tensor_transform mode=arithmetic option=add:1 apply=2,0 ! filesink location=%/out")
        self.assertEqual(self.read(), (values + numpy.array([1, 1, 0, 0, 1, 1, 1, 1], "uint8")).tobytes())

    # ---- Streams that meet -------------------------------------------------------------------

    def two(self, first, second, rates, middle):
        """Two streams of frames of one byte through `middle`, which is named m."""
        a, b = self.frames("a", first, 1), self.frames("b", second, 1)
        convert = "input-dim=1 input-type=uint8"
        seen = self.play(f"{middle} name=m ! identity name=seen silent=false ! filesink location=%/out " +
                         self.source("a", 1, "", convert, rates[0]) + "! queue ! m.sink_0 " +
                         self.source("b", 1, "", convert, rates[1]) + "! queue ! m.sink_1")
        pairs = numpy.frombuffer(self.read(), numpy.uint8).reshape(-1, 2)
        return a[:, 0], b[:, 0], pairs, seen

    def test_slowest_sends_the_last_frame(self):
        for element in ("tensor_mux sync-mode=SLOWEST", "tensor_merge mode=linear option=0 sync_mode=slowest"):
            with self.subTest(element):
                a, b, pairs, seen = self.two(30, 13, ("30/1", "12/1"), element)
                # routing.md 6.1: 13 frames, the last at 1 s; its partner is the last of the other stream.
                self.assertEqual(len(pairs), 13)
                self.assertEqual(list(pairs[:, 1]), list(b))
                self.assertEqual(pairs[-1, 0], a[-1])
                self.assertEqual(seen.times[-1], 10**9)

    def test_basepad_ends_with_the_last_frame_of_the_base(self):
        a, b, pairs, _ = self.two(20, 50, ("10/1", "25/1"), "tensor_mux sync-mode=basepad sync-option=1:0")
        self.assertEqual(len(pairs), 49)
        self.assertEqual(list(pairs[-1]), [a[19], b[48]])

    def test_nosync_pairs_by_number_whatever_the_word(self):
        a, b, pairs, seen = self.two(6, 4, ("30/1", "10/1"), "tensor_merge mode=linear option=0 sync-mode=whatever silent=TRUE")
        self.assertEqual(pairs.tolist(), [list(p) for p in zip(a, b)])
        self.assertEqual(seen.times, [i * 100 * MILLISECOND for i in range(4)])

    def test_refresh_sends_for_each_frame(self):
        a, b, pairs, _ = self.two(9, 5, ("30/1", "10/1"), "tensor_mux sync-mode=refresh")
        self.assertEqual(list(pairs[-1]), [a[-1], b[-1]])
        self.assertIn(len(pairs), range(5, 14), "one for each frame from the first of the later stream on")

    def test_pads_are_in_the_order_of_their_request(self):
        a, b = self.frames("a", 3, 1), self.frames("b", 3, 2)
        self.play("tensor_mux name=m ! filesink location=%/out " +
                  self.source("a", 1, "", "input-dim=1 input-type=uint8") + "! m.sink_1 " +
                  self.source("b", 2, "", "input-dim=2 input-type=uint8") + "! m.sink_0")
        self.assertEqual(self.read(), numpy.hstack([a, b]).tobytes())

    # ---- Streams that part -------------------------------------------------------------------

    def test_groups_of_a_pick_with_each_separator(self):
        values = self.frames("in", 3, 6)
        source = self.source("in", 6, "", "input-dim=1,2,3 input-type=uint8,uint8,uint8")
        parts = {"0": values[:, :1], "1": values[:, 1:3], "2": values[:, 3:]}
        for pick in ("0:2,1", "0+2;1", "0:2/1", "0+2.1"):
            with self.subTest(pick):
                self.play(source + f"! tensor_demux name=d tensorpick='{pick}' d.src_0 ! queue ! filesink location=%/x "
                          "d.src_1 ! queue ! filesink location=%/y")
                self.assertEqual(self.read("x"), numpy.hstack([parts["0"], parts["2"]]).tobytes())
                self.assertEqual(self.read("y"), parts["1"].tobytes())

    def test_segments_are_numbered_in_their_own_order(self):
        values = self.frames("in", 3, 12)
        source = self.source("in", 12, "", "input-dim=3:4 input-type=uint8")
        for segments, pick in (("3:2,3:1,3:1", "2,0"), ("3:2;3;3", "2;0"), ("3:2/3:1:1/3:1:1:1", "0/2")):
            with self.subTest(segments):
                seen = self.play(source + f"! tensor_split name=s tensorseg='{segments}' tensorpick='{pick}' "
                                 "s.src_0 ! queue ! identity name=seen silent=false ! filesink location=%/x "
                                 "s.src_1 ! queue ! filesink location=%/y")
                self.assertEqual(self.read("x"), values[:, :6].tobytes())
                self.assertEqual(self.read("y"), values[:, 9:].tobytes())
                self.assertIn("3:2", seen.caps)

    def test_windows_that_overlap_along_the_frames(self):
        values = self.frames("in", 8, 1, 2, 3)
        seen = self.play(self.source("in", 6, "", "input-dim=3:2:1:1 input-type=uint8", "10/1") +
                         "! tensor_aggregator frames-in=1 frames_out=4 frames-flush=2 frames-dim=1 concat=1 ! "
                         "identity name=seen silent=false ! filesink location=%/out")
        windows = [numpy.concatenate(list(values[i:i + 4]), axis=1) for i in (0, 2, 4)]
        self.assertEqual(self.read(), numpy.stack(windows).tobytes())
        self.assertEqual(seen.times, [0, 200 * MILLISECOND, 400 * MILLISECOND])
        self.assertIn("3:8", seen.caps)

    def test_frames_of_a_tensor_part_with_their_own_times(self):
        seen = self.play("videotestsrc num-buffers=6 ! video/x-raw,format=GRAY8,width=4,height=2,framerate=30/1 ! "
                         "tensor_converter frames-per-tensor=3 ! tensor_aggregator frames-in=3 frames-out=1 frames-dim=3 ! "
                         "identity name=seen silent=false ! fakesink")
        self.assertEqual(seen.sizes, 6 * [8])
        for i, time in enumerate(seen.times):
            self.assertAlmostEqual(time, i * 10**9 / 30, delta=1)

    def test_a_condition_by_numbers(self):
        values = self.frames("in", 12, 4)
        source = self.source("in", 4, "", "input-dim=4 input-type=uint8")
        lines = {
            "compared-value=3 compared-value-option=0 operator=2 supplied-value=125.5 then=0 else=1": values[values.mean(axis=1).astype(int) > 125],
            "compared-value=A_VALUE compared-value-option=2:0:0:0,0 operator=less_than supplied-value=100 then=passthrough else=skip": values[values[:, 2] < 100],
            "compared_value=0 compared-value-option=0:0,0 operator='range inclusive' supplied-value=50,150 else=SKIP": values[(values[:, 0] >= 50) & (values[:, 0] <= 150)],
        }
        for line, expected in lines.items():
            with self.subTest(line):
                self.play(source + f"! tensor_if name=i {line} i.src_0 ! filesink location=%/out")
                self.assertEqual(self.read(), expected.tobytes())

    def test_a_sparse_stream_through_capsfilters(self):
        values = self.frames("in", 5, 4, 6, element="float32", high=4)
        values[values < 3] = 0
        (self.path / "in").write_bytes(values.tobytes())
        self.play(self.source("in", 96, "", "input-dim=6:4 input-type=float32") +
                  "! tensor_sparse_enc ! other/tensors,format=sparse,framerate=0/1 ! tensor_sparse_dec ! "
                  "other/tensors,format=static,num_tensors=1,dimensions=6:4:1:1,types=float32,framerate=30/1 ! filesink location=%/out")
        self.assertEqual(self.read(), values.tobytes())

    def test_regions_beyond_the_frame_are_clipped(self):
        values = self.frames("in", 2, 6, 8, 3)
        regions = numpy.array([[[1, 2, 3, 2], [6, 4, 9, 9]], [[0, 0, 8, 6], [7, 5, 1, 1]]], "float32")
        (self.path / "info").write_bytes(regions.tobytes())
        self.play("tensor_crop name=c lateness=-1 ! filesink location=%/out " +
                  self.source("in", 144, "", "input-dim=3:8:6 input-type=uint8") + "! c.raw " +
                  self.source("info", 32, "", "input-dim=4:2 input-type=float32") + "! other/tensors,format=flexible ! c.info")
        expected = b""
        for frame, boxes in zip(values, regions.astype(int)):
            for x, y, w, h in boxes:
                part = frame[y:y + h, x:x + w]
                words = [0xFEEDCCED, 0xDE001000, 5, 3, part.shape[1], part.shape[0], 1, *12 * [0], 1, 4]
                expected += struct.pack("<21I", *words).ljust(128, b"\0") + part.tobytes()
        self.assertEqual(self.read(), expected)

    # ---- tensor_filter and tensor_decoder ----------------------------------------------------

    def test_a_lua_script_in_the_line(self):
        values = self.frames("in", 3, 4, high=100)
        script = ("inputTensorsInfo = {num = 1, dim = {{4, 1, 1, 1}}, type = {'uint8'}} "
                  "outputTensorsInfo = {num = 1, dim = {{4, 1, 1, 1}}, type = {'float32'}} "
                  "function nnstreamer_invoke() local i, o = input_tensor(1), output_tensor(1) "
                  "for k = 1, 4 do o[k] = i[k] / 2 + math.floor(os.time() / os.time()) end end")
        self.play_script(self.source("in", 4, "", "input-dim=4 input-type=uint8") +
                         f'! tensor_filter framework=lua model="{script}" ! filesink location=%/out')
        self.assertEqual(self.read(), (values / 2 + 1).astype("float32").tobytes())

    def test_a_python_script_with_arguments_and_combinations(self):
        values = self.frames("in", 3, 6, high=100)
        (self.path / "adds.py").write_text(
            "import numpy as np\nimport nnstreamer_python as nns\n"
            "class CustomFilter(object):\n"
            "  def __init__(self, *args):\n    self.number = int(args[0]) * int(args[1])\n"
            "  def getInputDim(self):\n    return [nns.TensorShape([4, 1, 1], np.uint8)]\n"
            "  def getOutputDim(self):\n    shape = nns.TensorShape([4], type=np.uint8)\n    return [shape]\n"
            "  def invoke(self, input_array):\n    return [input_array[0] + np.uint8(self.number)]\n")
        (self.path / "settings").write_text(f"model = {self.path}/adds.py\ncustom=3 4\nframework = python3\n")
        self.play_script(self.source("in", 6, "", "input-dim=2,4 input-type=uint8,uint8") +
                         "! tensor_filter config-file=%/settings input=4 inputtype=uint8 outputtype=uint8 "
                         "input-combination=1 output-combination=i0,o0 ! other/tensors,format=static,num_tensors=2,"
                         "dimensions=(string)2.4,types=(string)uint8.uint8 ! filesink location=%/out")
        self.assertEqual(self.read(), numpy.hstack([values[:, :2], values[:, 2:] + 12]).astype("uint8").tobytes())

    def test_outputs_are_in_the_models_order_behind_the_inputs(self):
        values = self.frames("in", 3, 5, high=100)
        (self.path / "two.py").write_text(
            "import numpy as np\nimport nnstreamer_python as nns\n"
            "class CustomFilter(object):\n"
            "  def getInputDim(self):\n    return [nns.TensorShape([3], np.uint8), nns.TensorShape([2], np.uint8)]\n"
            "  def getOutputDim(self):\n    return [nns.TensorShape([3], np.uint8), nns.TensorShape([2], np.int16)]\n"
            "  def invoke(self, x):\n    return [x[0] + np.uint8(1), x[1].astype(np.int16) * 2]\n")
        self.play_script(self.source("in", 5, "", "input-dim=2,3 input-type=uint8,uint8") +
                         "! tensor_filter model=' %/two.py ' input-combination=1,0 output-combination=o1,o0,i1 input=3:1:1.2:1 "
                         "inputtype=uint8,uint8 inputname=a,b inputlayout=nhwc.none output=3,2 outputtype=uint8.int16 ! "
                         "filesink location=%/out")
        self.assertEqual(self.read(), b"".join(frame[2:].tobytes() + (frame[2:] + 1).astype("uint8").tobytes() +
                                               (2 * frame[:2].astype("int16")).tobytes() for frame in values))

    def test_a_loop_counts(self):
        values = self.frames("in", 30, 1)
        self.play("tensor_mux name=m sync-mode=nosync ! tensor_transform mode=arithmetic option=add:1 ! tee name=t "
                  "t. ! queue ! filesink location=%/out t. ! queue ! tensor_demux name=d tensorpick=1 d.src_0 ! "
                  "tensor_reposink slot-index=3 silent=false " +
                  self.source("in", 1, "", "input-dim=1 input-type=uint8") + "! m.sink_0 tensor_reposrc silent=false slot-index=3 "
                  "caps=other/tensor,dimension=(string)1:1:1:1,type=(string)uint8,framerate=(fraction)30/1 ! m.sink_1")
        self.assertEqual(self.read(), numpy.hstack([values + 1, numpy.arange(1, 31, dtype="uint8")[:, None]]).tobytes())

    def test_seventeen_tensors_become_bytes(self):
        values = self.frames("in", 3, 17 * 16)
        dims, types = ",".join(17 * ["16"]), ",".join(17 * ["uint8"])
        seen = self.play(self.source("in", 272, "", f"input-dim={dims} input-type={types}") +
                         "! tensor_decoder mode=octet_stream ! identity name=seen silent=false ! filesink location=%/out")
        self.assertEqual(self.read(), values.tobytes())
        self.assertEqual(seen.sizes, 3 * [272])


if __name__ == "__main__":
    tap_runner.main()
