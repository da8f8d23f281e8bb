#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Frames without elements: pushed, made and read by scripts, and as results. None ends a stream."""

import pathlib
import sys
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

try:
    import numpy as np
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

FLEXIBLE = "other/tensors,format=flexible,framerate=0/1"
STATIC = "other/tensors,format=static,num_tensors=1,dimensions=(string)3:2,types=float32,framerate=0/1"
COLUMNS = 'weir-columns="x1,y1,x2,y2,score"'
MS = 1_000_000


class Empty(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def script(self, name, text):
        path = self.folder / name
        path.write_text("import numpy as np\nfrom weir import TensorShape\n" + text)
        return path

    def filter(self, lines, shapes="[TensorShape([2, 1], np.float32)]"):
        return self.script("filter.py", f"class CustomFilter:\n    def setInputDim(self, shapes): return {shapes}\n"
                           "    def invoke(self, arrays):\n" + "".join(f"        {line}\n" for line in lines))

    def frames(self, arrays, text, sink="tensor_sink"):
        """Pushes the arrays at 0, 40, 80 ms ... and returns the frames."""
        with weir.Pipeline(f"{text} ! {sink} name=out") as pipeline:
            for number, array in enumerate(arrays):
                pipeline.push("in", array, pts=number * 40 * MS, duration=40 * MS)
            pipeline.end("in")
            frames = []
            while (frame := pipeline.pull("out", 60)) is not None:
                frames.append(frame)
            return frames

    def test_are_pushed_and_pulled_with_their_shape(self):
        arrays = [np.ones((2, 3), np.float32), np.ones((0, 3), np.float32), np.ones((1, 3), np.float32)]
        for caps in (f"appsrc name=in caps={FLEXIBLE}", f"appsrc name=in ! {FLEXIBLE}"):
            frames = self.frames(arrays, caps)
            self.assertEqual([frame[0].shape for frame in frames], [(2, 3), (0, 3), (1, 3)], caps)
            self.assertEqual([frame.pts for frame in frames], [0, 40 * MS, 80 * MS])

    def test_make_derived_caps_flexible(self):
        arrays = [np.ones((0, 3), np.float32), np.ones((2, 3), np.float32)]
        frames = self.frames(arrays, "appsrc name=in")
        self.assertEqual([frame[0].shape for frame in frames], [(0, 3), (2, 3)])

    def test_are_gaps_where_caps_are_static(self):
        arrays = [np.ones((0, 3), np.float32), np.ones((2, 3), np.float32), np.ones((0, 3), np.float32), np.zeros((2, 3), np.float32)]
        for caps in (f"appsrc name=in caps={STATIC}", f"appsrc name=in ! {STATIC}", "appsrc name=in ! tensor_aggregator frames-dim=1"):
            frames = self.frames(arrays, caps)
            self.assertEqual([frame.pts for frame in frames], [40 * MS, 120 * MS], caps)

    def test_are_no_results(self):
        arrays = [np.array([[1, 2, 3, 4, 0.5]], np.float32), np.zeros((0, 5), np.float32)]
        frames = self.frames(arrays, f"appsrc name=in caps={FLEXIBLE},{COLUMNS}")
        self.assertEqual([len(frame.results) for frame in frames], [1, 0])

    def test_are_no_results_after_elements_that_read_results(self):
        arrays = [np.array([[1, 2, 3, 4, 0.5]], np.float32), np.zeros((0, 5), np.float32)]
        zones = self.script("zones.json", "")
        zones.write_text('{"version": 1, "zones": [{"name": "gate", "line": [[0, 0], [9, 9]]}]}')
        for element in ("tensor_tracker", f"tensor_tracker ! tensor_zones zones={zones}"):
            frames = self.frames(arrays, f"appsrc name=in caps={FLEXIBLE},{COLUMNS} ! {element}")
            self.assertEqual([len([row for row in frame.results if row.box]) for frame in frames], [1, 0], element)

    def test_pass_elements_that_only_route_them(self):
        arrays = [np.zeros((0, 4), np.float32), np.ones((1, 4), np.float32)]
        routes = "tensor_mux", "tensor_demux name=d d.src_0", "tensor_if name=i compared-value=A_VALUE compared-value-option=0:0:0:0,0 operator=GE supplied-value=0 then=SKIP else=PASSTHROUGH i.src_1"
        for route, shapes in zip(routes, ([(0, 4), (1, 4)], [(0, 4), (1, 4)], [(0, 4)])):
            frames = self.frames(arrays, f"appsrc name=in caps={FLEXIBLE} ! {route}")
            self.assertEqual([frame[0].shape for frame in frames], shapes, route)

    def test_a_script_has_no_result(self):
        for nothing in ("None", "[]", "[np.empty((0, 2), np.float32)]"):
            path = self.filter(["a, = arrays", f"return [a.view(np.float32)[:2]] if a[0] else {nothing}"])
            arrays = [np.array([[value, 5, 5]], np.float32) for value in (1, 0, 2)]
            frames = self.frames(arrays, f"appsrc name=in ! tensor_filter model={path}")
            self.assertEqual([frame[0].ravel().tolist() for frame in frames], [[1, 5], [2, 5]], nothing)

    def test_a_script_decides_the_number_of_rows(self):
        # Of an array with two dimensions, and of one whose rows setInputDim gives.
        for rows in ("a.reshape(-1, 2)[a.reshape(-1, 2)[:, 0] > 0]", "a.reshape(-1, 2)[a.reshape(-1, 2)[:, 0] > 0].ravel()"):
            path = self.filter(["a, = arrays", f"return [{rows}]"])
            arrays = [np.array(a, np.float32) for a in ([[1, 2], [3, 4]], [[0, 1], [0, 2]], [[0, 1], [5, 6]])]
            frames = self.frames(arrays, f"appsrc name=in ! tensor_filter model={path} invoke-dynamic=true")
            self.assertEqual([frame[0].tolist() for frame in frames], [[[1, 2], [3, 4]], [], [[5, 6]]], rows)
            self.assertEqual(frames[1][0].shape, (0, 2))

    def test_a_script_gets_no_events(self):
        path = self.filter(["f = np.zeros(4, np.uint8)", "f[arrays[0].view(np.float32).astype(int)] = 9", "return [f]"],
                           "[TensorShape([4, 1], np.uint8)]")
        arrays = [np.array([1], np.float32), np.zeros((0,), np.float32), np.array([0, 3], np.float32)]
        frames = self.frames(arrays, f"appsrc name=in caps={FLEXIBLE} ! tensor_filter model={path}")
        self.assertEqual([frame[0].ravel().tolist() for frame in frames], [[0, 9, 0, 0], [0, 0, 0, 0], [9, 0, 0, 9]])

    def test_a_script_in_a_worker_process_gets_what_it_gets_without_one(self):
        path = self.filter(["return [np.array([arrays[0].size], np.float32)]"], "[TensorShape([1, 1], np.float32)]")
        arrays = [np.array([1], np.float32), np.zeros((0,), np.float32), np.array([0, 3], np.float32)]
        frames = [[frame[0].ravel().tolist() for frame in self.frames(
            arrays, f"appsrc name=in caps={FLEXIBLE} ! tensor_filter model={path} {isolate}")] for isolate in ("", "isolate=process")]
        self.assertEqual(frames, [[[1], [0], [2]]] * 2)

    def test_are_gaps_of_sound(self):
        for caps in ("audio/x-raw,format=F32LE,rate=8000,channels=2,layout=interleaved", "audio/x-raw,format=S16LE,rate=8000,channels=1"):
            columns, kind = (2, np.float32) if "F32LE" in caps else (1, np.int16)
            arrays = [np.zeros((4, columns), kind), np.zeros((0, columns), kind), np.ones((4, columns), kind)]
            for source in (f"appsrc name=in caps={caps}", f"appsrc name=in ! {caps}"):
                frames = self.frames(arrays, source, "appsink")
                self.assertEqual([(frame.pts, len(bytes(frame[0]))) for frame in frames],
                                 [(0, arrays[0].nbytes), (80 * MS, arrays[2].nbytes)], source)

    def test_a_converter_waits_for_more(self):
        path = self.script("lines.py", """class CustomConverter:
    def __init__(self): self.rest = b""
    def convert(self, arrays):
        *lines, self.rest = (self.rest + bytes(arrays[0])).split(b"\\n")
        rows = np.array([[float(v) for v in line.split(b",")] for line in lines], np.float32)
        if not len(rows): return None
        return [TensorShape([3, len(rows)], np.float32)], [rows.view(np.uint8)], 0, 1
""")
        pieces = [b"1,2,", b"3\n4,5,6\n7", b",8,9\n"]
        frames = self.frames([np.frombuffer(piece, np.uint8) for piece in pieces],
                                f"appsrc name=in caps=application/octet-stream ! tensor_converter mode=custom-script:{path}")
        self.assertEqual([frame[0].reshape(-1, 3).tolist() for frame in frames], [[[1, 2, 3], [4, 5, 6]], [[7, 8, 9]]])

    @unittest.skipUnless(has_engine("lua"), "no engine lua")
    def test_a_lua_script_has_no_result(self):
        script = ("inputTensorsInfo={num=1,dim={{2,1}},type={'float32'}} outputTensorsInfo={num=1,dim={{1}},type={'float32'}} "
                  "function nnstreamer_invoke() local x=input_tensor(1)[1] if x==0 then return false end output_tensor(1)[1]=x end")
        arrays = [np.array([[value, 5]], np.float32) for value in (1, 0, 2)]
        frames = self.frames(arrays, f'appsrc name=in ! tensor_filter framework=lua model="{script}"')
        self.assertEqual([frame[0].ravel().tolist() for frame in frames], [[1], [2]])


if __name__ == "__main__":
    tap_runner.main()
