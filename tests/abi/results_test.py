#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares weir.results with the C header: results_test.py RESULTS_C11 RESULTS_PY. Ends with N passed, N failed."""

import importlib.util
import random
import struct
import subprocess
import sys
import unittest

try:
    import numpy
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)

PROGRAM, MODULE = sys.argv[1:3]
spec = importlib.util.spec_from_file_location("results", MODULE)
results = importlib.util.module_from_spec(spec)
sys.modules["results"] = results
spec.loader.exec_module(results)

KINDS = ["", "rows", "masks", "scores", "class-map", "depth", "text"]


def of_c(text, index):
    run = subprocess.run([PROGRAM, text, str(index)], capture_output=True, text=True, check=True)
    return run.stdout.strip()


def of_python(text, index):
    entry = (text.split(";") + [""] * (index + 1))[index]
    try:
        columns = results.parse_columns(entry)[0]
    except ValueError:
        return "invalid"
    place = [columns.index.get(name, -1) for name in ("x1", "score", "class", "track", "parent", "rotation", "points")]
    return " ".join(str(n) for n in [KINDS.index(columns.kind), columns.length, *place, columns.n_points,
                                     columns.point_length])


class Results(unittest.TestCase):
    def test_columns_are_those_of_the_c_header(self):
        texts = ["x1,y1,x2,y2,score,class,track,parent,rotation,xys:17;masks;scores;text;class-map;depth;;other",
                 "x1,x2,y1,y2", "x1,y1,x2", "x1,y1,score,x2,y2", "score,score", "xy", "xy:0", "xy:3,xys:2", "xys:21845",
                 "xys:21846", "a:65536", "a:65537", "a:65536,b", "a:", ":3", ",", "score,", "score:2,score", "x1:4",
                 "y1", "x1,y1,x2,y2,x1", "embedding:128,score", "a:1x", "a:-1", "a:99999999999", "masks,score", "XY:2"]
        for text in texts:
            for index in range(text.count(";") + 2):
                with self.subTest(text=text, index=index):
                    self.assertEqual(of_python(text, index), of_c(text, index))

    def test_any_order_of_columns_agrees(self):
        choice = random.Random(4)
        parts = ["x1", "y1", "x2", "y2", "score", "class", "xys:2", "xy:3", "track:2", "", "e:5", "parent"]
        for _ in range(150):
            text = ",".join(choice.choices(parts, k=choice.randint(1, 6)))
            if choice.random() < 0.5:
                text = "x1,y1,x2,y2," + text
            with self.subTest(text=text):
                self.assertEqual(of_python(text, 0), of_c(text, 0))

    def test_rows_are_read_by_name(self):
        columns = results.parse_columns("score,x1,y1,x2,y2,class,extra:2,track,parent,rotation,xy:1")[0]
        data = struct.pack("<26f", *([0.5, 1, 2, 3, 4, 9, 7, 7, 5, -1, 0.25, 6, 8] + [0] * 13))
        found = results.rows(columns, data)
        self.assertEqual(len(found), 1)
        row = found[0]
        self.assertEqual((row.box, row.score, row.class_index, row.track, row.parent, row.rotation, row.points),
                         ((1, 2, 3, 4), 0.5, 9, 5, -1, 0.25, [(6, 8, 1.0)]))
        self.assertEqual(len(results.rows(columns, data, background=True)), 2)
        table = results.structured(columns, numpy.frombuffer(data, dtype=numpy.float32))
        self.assertEqual(table["box"].tolist(), [[1, 2, 3, 4], [0, 0, 0, 0]])
        self.assertEqual(table["extra"][0].tolist(), [7, 7])
        self.assertEqual(table["points"].shape, (2, 1, 2))

    def test_numbers_that_no_integer_holds_are_absent(self):
        columns = results.parse_columns("score,class,track,parent")[0]
        row = results.rows(columns, numpy.array([1, numpy.nan, -3, numpy.inf], dtype=numpy.float32))[0]
        self.assertEqual((row.class_index, row.track, row.parent), (0, 0, -1))
        self.assertEqual(results.rows(columns, numpy.array([numpy.nan, 0, 0, 0], dtype=numpy.float32)), [])

    def test_rows_that_do_not_fit_are_errors(self):
        columns = results.parse_columns("score,class;masks")
        self.assertEqual(results.rows(columns[0], b""), [])
        for tensor, words in ((b"abc", "3 bytes"), (b"\0" * 12, "3 numbers are not rows of 2"),
                              (numpy.zeros(2), "float64")):
            with self.subTest(words=words), self.assertRaisesRegex(ValueError, words):
                results.rows(columns[0], tensor)
        with self.assertRaisesRegex(ValueError, "a tensor of masks has no rows"):
            results.rows(columns[1], b"\0" * 8)

    def test_texts_end_at_the_first_zero(self):
        table = numpy.frombuffer(b"ab\0xGr\xfc\0", dtype=numpy.uint8).reshape(2, 4)
        self.assertEqual(results.texts(table), ["ab", "Gr\ufffd"])
        self.assertEqual(results.sources("a;b", 3), ["a", "b", ""])


if __name__ == "__main__":
    outcome = unittest.main(argv=[sys.argv[0]], exit=False).result
    failed = len(outcome.failures) + len(outcome.errors)
    print(f"{max(outcome.testsRun - failed, 0)} passed, {failed} failed")
    sys.exit(failed > 0)
