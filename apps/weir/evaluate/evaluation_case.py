# SPDX-License-Identifier: LGPL-2.1-or-later
"""Helpers of the tests of weir evaluate: pictures whose pixels are the results of a pipeline.

A picture has 7 x ROWS blocks of grey. A pipeline without a network reads them as rows of results: the edges of a box, score, class,
track. So the results are known exactly, and everything but the network is the real one.
"""

import json

import numpy
from PIL import Image
from weir_case import WITHOUT_LEAKS, Case, weir

ROWS, COLUMNS, SIZE = 10, 7, (280, 280)  # SIZE: width and height of the pictures; a box's edges are 1 to 255
WHOLE = ("tensor_preprocess width=7 height=10 channel-order=GRAY type=float32 layout=NCHW ! tensor_transform mode=arithmetic "
         "option=add:0.5 ! tensor_transform mode=typecast option=uint8 ! tensor_transform mode=typecast option=float32 ! ")
COLUMN_CAPS = 'other/tensors,weir-columns=(string)"x1,y1,x2,y2,score,class,track"'
BOXES = WHOLE + COLUMN_CAPS
LABELS = WHOLE + 'other/tensors,weir-columns=(string)"skipped:4,score,class,skipped_too"'


def write_picture(path, rows, size=SIZE):
    """Rows of x1, y1, x2, y2, score, class, track. Rows of zeros are background."""
    cells = numpy.zeros((ROWS, COLUMNS), numpy.uint8)
    for i, row in enumerate(rows):
        cells[i, :len(row)] = row
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(numpy.kron(cells, numpy.ones((size[1] // ROWS, size[0] // COLUMNS), numpy.uint8))).save(path)


def scores(done, index=0):
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)["results"][index]["scores"]


class Coco(Case):
    def setUp(self):
        super().setUp()
        self.truth = {"images": [], "annotations": [], "categories": []}
        self.pictures = []

    def add(self, boxes, rows, **more):
        """boxes: category, x, y, width, height of the truth; rows: those that are found."""
        number = len(self.truth["images"]) + 1
        name = f"{number}.png"
        write_picture(self.folder / "set" / name, rows)
        self.truth["images"].append({"id": number, "file_name": name, "width": SIZE[0], "height": SIZE[1]})
        for category, *box in boxes:
            self.truth["annotations"].append({"id": len(self.truth["annotations"]) + 1, "image_id": number,
                                              "category_id": category + 1, "bbox": box, **more})

    def write(self, categories=("thing",)):
        self.truth["categories"] = [{"id": i + 1, "name": name} for i, name in enumerate(categories)]
        (self.folder / "set" / "truth.json").write_text(json.dumps(self.truth))

    def evaluate(self, *options, pipeline=BOXES):
        return weir("evaluate", pipeline, self.folder / "set", *options, **WITHOUT_LEAKS)
