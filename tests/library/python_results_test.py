#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests what frames of the package weir hold: iteration, results as objects, source maps, stats."""

import pathlib
import sys
import tempfile
import unittest

import tap_runner

try:
    import numpy as np
    import weir
except ImportError as missing:
    print(f"1..0 # SKIP {missing}")
    sys.exit(0)

LOOP = "appsrc name=in ! tensor_sink name=out"


class Results(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.labels = pathlib.Path(folder.name) / "labels.txt"
        self.labels.write_text("cat\ndog\nkäfer\n", encoding="utf-8")

    def decoder(self, more=""):
        """Reads rows of x1, y1, x2, y2, score, class in a picture of 100 x 100."""
        return f"tensor_decoder mode=detection custom=head:yolov10,input:100:100,name:net labels={self.labels} {more}"

    def frames(self, rows, text, sink="tensor_sink"):
        with weir.Pipeline(f"appsrc name=in ! {text} ! {sink} name=out") as pipeline:
            for number, part in enumerate(rows):
                pipeline.push("in", np.array([part], np.float32), pts=number * 40_000_000, duration=40_000_000)
            pipeline.end("in")
            return list(pipeline.frames("out", timeout=60))

    def test_are_objects_with_labels(self):
        frame, = self.frames([[[10, 20, 30, 40, 0.9, 1], [50, 60, 70, 80, 0.5, 0]]], self.decoder())
        dog, cat = frame.results
        self.assertEqual((dog.box, dog.class_index, dog.label, dog.source), ((10, 20, 30, 40), 1, "dog", "net"))
        self.assertAlmostEqual(dog.score, 0.9, places=6)
        self.assertEqual((cat.box, cat.label, cat.track, cat.parent, cat.number), ((50, 60, 70, 80), "cat", 0, -1, 1))
        self.assertEqual([columns.kind for columns in frame.columns], ["rows"])
        self.assertRegex(repr(cat), r"^<weir.results.Row label='cat', class_index=0, score=0.5, box=\(50.0, 60.0, 70.0, 80.0\), source='net'>$")

    def test_labels_that_are_missing_or_not_ascii(self):
        frame, = self.frames([[[10, 20, 30, 40, 0.9, 2], [50, 60, 70, 80, 0.5, 7]]], self.decoder())
        self.assertEqual([row.label for row in frame.results], ["käfer", None])

    def test_a_frame_without_objects_has_none(self):
        frame, = self.frames([[[10, 20, 30, 40, 0.01, 1]]], self.decoder("threshold=0.5"))
        self.assertEqual(frame.results, [])

    def test_tracks_stay(self):
        rows = [[[10 + i, 20, 30 + i, 40, 0.9, 1]] for i in range(5)]
        frames = self.frames(rows, self.decoder() + " ! tensor_tracker")
        tracks = {row.track for frame in frames for row in frame.results}
        self.assertEqual(len(frames), 5)
        self.assertEqual(len(tracks - {0}), 1)
        self.assertEqual([frame.pts for frame in frames], [i * 40_000_000 for i in range(5)])

    def test_a_stream_of_tensors_has_none(self):
        with weir.Pipeline(LOOP) as pipeline:
            pipeline.push("in", np.zeros(4, np.float32))
            frame = pipeline.pull("out", 60)
            with self.assertRaisesRegex(ValueError, "the stream has no results: its caps are other/tensors,.* put a tensor_decoder"):
                frame.results
            with self.assertRaisesRegex(ValueError, "the stream has no text but other/tensors: end it with tensor_decoder mode=json ! appsink"):
                frame.text
            self.assertEqual([columns.kind for columns in frame.columns], [""])
            self.assertIsNone(frame.label(0, 0))

    def test_tables_belong_to_the_rows_before_them(self):
        caps = 'other/tensors,format=static,num_tensors=4,types=\\"float32,uint8,uint8,float32\\",' \
               'dimensions=\\"6:2,2:1:2,4:2,5:1\\",framerate=0/1,weir-columns=\\"x1,y1,x2,y2,score,speed;masks;text;x1,y1,x2,y2,parent\\"'
        with weir.Pipeline(f'appsrc name=in caps="{caps}" ! tensor_sink name=out') as pipeline:
            pipeline.push("in", [np.array([[1, 2, 3, 4, 0, 9], [5, 6, 7, 8, 0.5, 3.5]], np.float32),
                                 np.array([[[1, 2]], [[3, 4]]], np.uint8),
                                 np.frombuffer(b"none" + b"two\0", np.uint8).reshape(2, 4),
                                 np.array([[0, 0, 1, 1, 1]], np.float32)])
            frame = pipeline.pull("out", 60)
        found, part = frame.results
        self.assertEqual((found.box, found.number, found.text, found.extra), ((5, 6, 7, 8), 1, "two", {"speed": 3.5}))
        np.testing.assert_array_equal(found.mask, [[3, 4]])
        self.assertEqual((part.parent, part.number, part.text, part.mask), (1, 2, None, None))

    def test_text_of_a_stream_of_text(self):
        frame, = self.frames([[[10, 20, 30, 40, 0.5, 1]]], self.decoder() + " ! tensor_decoder mode=json", "appsink")
        self.assertTrue(frame.text.endswith("\n"))
        self.assertIn('"box":[10,20,30,40]', frame.text)


class Frames(unittest.TestCase):
    def test_are_iterated_until_the_end(self):
        with weir.Pipeline(LOOP) as pipeline:
            for i in range(3):
                pipeline.push("in", np.full(1, i, np.uint8))
            pipeline.end("in")
            self.assertEqual([int(frame[0][0]) for frame in pipeline.frames()], [0, 1, 2])
            self.assertEqual(list(pipeline.frames()), [])

    def test_the_counters_of_a_model_stay_after_the_last_frame(self):
        with tempfile.NamedTemporaryFile(suffix=".py", mode="w") as script:
            script.write("class CustomFilter:\n    def setInputDim(self, dims):\n        return dims\n    def invoke(self, arrays):\n        return arrays\n")
            script.flush()
            pipeline = weir.Pipeline("videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8,width=4,height=2 ! tensor_converter ! "
                                     f"tensor_filter name=nn model={script.name} ! tensor_sink")
            self.assertEqual(len(list(pipeline.frames(timeout=60))), 3)
            self.assertEqual(pipeline.state, "stopped")
            for stats in (pipeline.stats("nn"), pipeline.stats()["nn"]):
                self.assertEqual((stats["received"], stats["invokes"]), (3, 3))

    def test_start_a_pipeline_that_is_stopped(self):
        pipeline = weir.Pipeline("videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8,width=4,height=2 ! tensor_converter ! tensor_sink name=s")
        frames = list(pipeline.frames(timeout=60))
        self.assertEqual((pipeline.state, pipeline.stats("s")["received"]), ("stopped", 3))
        self.assertEqual([frame[0].shape for frame in frames], [(1, 2, 4, 1)] * 3)
        self.assertRegex(repr(frames[0]), r"^<weir.Frame pts=0: uint8 \(1, 2, 4, 1\)>$")
        self.assertEqual([array.shape for array in frames[0]], [(1, 2, 4, 1)])

    def test_leave_a_pipeline_stopped_when_the_loop_ends_early(self):
        pipeline = weir.Pipeline("videotestsrc ! video/x-raw,format=GRAY8,width=4,height=2 ! tensor_converter ! tensor_sink")
        for _round in range(2):
            for number, _frame in enumerate(pipeline.frames(timeout=60)):
                self.assertEqual(pipeline.state, "playing")
                if number == 3:
                    break
            self.assertEqual(pipeline.state, "stopped")

    def test_leave_a_pipeline_playing_that_played_before(self):
        with weir.Pipeline(LOOP) as pipeline:
            pipeline.push("in", np.zeros(1, np.uint8))
            next(iter(pipeline.frames(timeout=60)))
            self.assertEqual(pipeline.state, "playing")

    def test_time_limit(self):
        with weir.Pipeline(LOOP) as pipeline, self.assertRaisesRegex(TimeoutError, "no frame came from out in 0.01 seconds"):
            next(pipeline.frames("out", timeout=0.01))

    def test_an_error_of_the_pipeline_is_raised(self):
        pipeline = weir.Pipeline("filesrc location=/no/such/file ! tensor_sink name=out")
        with self.assertRaisesRegex(weir.Error, "/no/such/file"):
            list(pipeline.frames())

    def test_which_sink_must_be_clear(self):
        two = weir.Pipeline("appsrc ! tensor_sink name=a appsrc ! appsink name=b")
        with self.assertRaisesRegex(ValueError, r"several sinks, so name one: pipeline.frames\('a'\); they are 'a', 'b'"):
            two.frames()
        with self.assertRaisesRegex(ValueError, "no sink for frames: end it with tensor_sink name=out"):
            weir.Pipeline("appsrc ! fakesink").frames()
        with self.assertRaisesRegex(weir.Error, "no element of the pipeline has this name"):
            next(two.frames("c"))

    def test_source_maps(self):
        pipeline = weir.Pipeline("videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=640,height=480 ! "
                                 "tensor_preprocess width=32 height=16 ! tensor_sink")
        frame, = pipeline.frames(timeout=60)
        way = frame.source_map
        self.assertEqual((way.source_size, way.size), ((640, 480), (32, 16)))
        self.assertEqual(way.matrix, ((20, 0, 0), (0, 30, 0)))
        self.assertEqual((way.to_source(1, 2), way.to_tensor(320, 480)), ((20, 60), (16, 16)))
        self.assertEqual(repr(way), "<weir.SourceMap from 32x16 to 640x480>")
        self.assertEqual(len(frame.source_maps), 1)

    def test_tensors_that_are_no_picture_have_no_map(self):
        with weir.Pipeline(LOOP) as pipeline:
            pipeline.push("in", np.zeros(4, np.float32))
            frame = pipeline.pull("out", 60)
        self.assertIsNone(frame.source_map)
        self.assertEqual(frame.source_maps, ())


class Stats(unittest.TestCase):
    def test_are_a_dict(self):
        with weir.Pipeline("appsrc name=in ! identity name=i ! tensor_sink name=out") as pipeline:
            pipeline.push("in", np.zeros(4, np.float32))
            pipeline.end("in")
            self.assertEqual(len(list(pipeline.frames("out", timeout=60))), 1)
            self.assertTrue(pipeline.wait(60))  # the sink counts a frame as consumed after it has delivered it
            stats = pipeline.stats("out")
            self.assertEqual((stats["received"], stats["consumed"], stats["held"]), (1, 1, 0))
            self.assertEqual(pipeline.stats()["out"], stats)
            self.assertEqual(pipeline.elements(), {"in": "appsrc", "i": "identity", "out": "tensor_sink"})
            self.assertNotIn("in", pipeline.stats())
            with self.assertRaisesRegex(weir.Error, "appsrc has no such property"):
                pipeline.stats("in")


if __name__ == "__main__":
    tap_runner.main()
