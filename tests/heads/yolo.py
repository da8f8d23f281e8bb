# SPDX-License-Identifier: LGPL-2.1-or-later
"""Outputs of the YOLO family, written from what its authors publish.

YOLOv3: Redmon and Farhadi, "YOLOv3: An Incremental Improvement", 2018 (section 2.1: b = sigma(t) + c, p exp(t)).
YOLOv5, v8, v11: the pages "Ultralytics YOLOv5 Architecture" (b = 2 sigma(t) - 0.5 + c, p (2 sigma(t))^2) and "Export", whose files
name their task in the metadata.
YOLOv7: Wang et al., "YOLOv7", 2022, with the equations of YOLOv5. YOLOv10: Wang et al., 2024: no suppression.
YOLOX: Ge et al., "YOLOX: Exceeding YOLO Series in 2021": no anchors, distances from the corner of a cell.
Masks: Bolya et al., "YOLACT", 2019: sigma of a sum of prototypes. Rotated boxes: centre, size and angle in radians.
"""

import numpy

from scene import Example, View, cell_of, cells, logit, sigmoid, things_of

STRIDES = (8, 16, 32)
OF_THING = (32, 16, 8)  # the grid that finds each of the three things
SQUARE = View((640, 480), (320, 320))
CLASSES = 5
ANCHORS = {  # pixels, three of each grid, from the papers
    "yolov3": [(10, 13), (16, 30), (33, 23), (30, 61), (62, 45), (59, 119), (116, 90), (156, 198), (373, 326)],
    "yolov7": [(12, 16), (19, 36), (40, 28), (36, 75), (76, 55), (72, 146), (142, 110), (192, 243), (459, 401)]}


def noise(rng, places, values):
    """Rows that are no objects: boxes near their cells, and scores below every threshold."""
    rows = rng.uniform(0.0, 0.12, (len(places), values))
    rows[:, :2] = (places[:, :2] + rng.uniform(0.2, 0.8, (len(places), 2))) * places[:, 2:]
    rows[:, 2:4] = rng.uniform(8, 60, (len(places), 2))
    return rows


def rows_of(view, things, anchors=1, objectness=False, extra=0):
    """The rows of all cells: x, y, width, height in pixels, objectness, classes, `extra` numbers. Each thing is in its cell
    and, less certain and a pixel aside, in the next one. Returns the rows, and those of each thing."""
    rng, places = numpy.random.default_rng(1), cells(view.input, STRIDES)
    blocks, at = [], []
    for stride in STRIDES:
        blocks += [places[places[:, 2] == stride]] * anchors
    rows = noise(rng, numpy.concatenate(blocks), 4 + objectness + CLASSES + extra)
    first = 4 + objectness
    for number, (thing, stride) in enumerate(zip(things, OF_THING)):
        of_grid = cell_of(blocks[STRIDES.index(stride) * anchors], view.centred(thing)[:2], stride)
        start = sum(len(block) for block in blocks[:STRIDES.index(stride) * anchors + number % anchors])
        at.append((start + of_grid, start + of_grid + 1))
        for row, aside, less in zip(at[-1], (0, 1), (0, 0.1)):
            rows[row, :4] = view.centred(thing) + (aside, 0, 0, 0)
            if objectness:
                rows[row, 4] = 0.95
            rows[row, first + thing.index] = (thing.score - less) / (0.95 if objectness else 1)
    return rows, at


def in_order(rows, order, kind, view, places=2):
    """`planes`: all cells of a number together. Of 8 bits, boxes are parts of the picture, as exporters of such models
    do: otherwise one scale would serve for pixels and for scores."""
    rows = rows.copy()
    if kind in ("uint8", "int8"):
        rows[:, :4] = view.part(rows[:, :4])
        for first in range(places, rows.shape[1] if places > 2 else 0, 3):
            rows[:, first:first + 2] = view.part(rows[:, first:first + 2])
    return (rows.T if order == "planes" else rows)[None]


def yolov8(order, kind):
    things = things_of(SQUARE.source)
    rows, _ = rows_of(SQUARE, things)
    return Example(SQUARE, [("output0", in_order(rows, order, kind, SQUARE))], things, metadata={"task": "detect"})


def yolov5(order, kind):
    things = things_of(SQUARE.source)
    rows, _ = rows_of(SQUARE, things, anchors=3, objectness=True)
    return Example(SQUARE, [("output", in_order(rows, order, kind, SQUARE))], things)


def yolo_nas(order, kind):
    """Probabilities and corners in pixels of each cell, in two outputs: Deci, "YOLO-NAS", 2023; Xu et al., "PP-YOLOE", 2022, whose
    scores have all cells of a class together."""
    things = things_of(SQUARE.source)
    rows, _ = rows_of(SQUARE, things)
    corners = numpy.concatenate([rows[:, :2] - rows[:, 2:4] / 2, rows[:, :2] + rows[:, 2:4] / 2], axis=1)
    scores = rows[:, 4:]
    outputs = [("scores", (scores.T if "planes" in order else scores)[None]), ("boxes", corners[None])]
    return Example(SQUARE, outputs[::-1] if order.startswith("boxes") else outputs, things)


def yolox(order, kind):
    """In rows the numbers are relative to the cells, as YOLOX exports them; in planes they are pixels."""
    things = things_of(SQUARE.source)
    rows, _ = rows_of(SQUARE, things, objectness=True)
    if order == "rows":
        places = cells(SQUARE.input, STRIDES)
        rows[:, :2] = rows[:, :2] / places[:, 2:] - places[:, :2]
        rows[:, 2:4] = numpy.log(rows[:, 2:4] / places[:, 2:])
        return Example(SQUARE, [("output", rows[None])], things, labels=["a", "b", "c", "d", "e"],
                       scores={"float32": 0.001, "float16": 0.004, "uint8": 0.05, "int8": 0.05})
    return Example(SQUARE, [("output", in_order(rows, order, kind, SQUARE))], things, labels=["a", "b", "c", "d", "e"])


def yolov8_obb(order, kind):
    things = things_of(SQUARE.source)
    for thing, angle in zip(things, (0.5, -0.3, 1.2)):
        thing.rotation = angle
    rows, at = rows_of(SQUARE, things, extra=1)
    for thing, of_thing in zip(things, at):
        rows[list(of_thing), -1] = thing.rotation
    return Example(SQUARE, [("output0", in_order(rows, order, kind, SQUARE))], things, metadata={"task": "obb"})


def yolov8_pose(order, kind):
    points = 6
    things = things_of(SQUARE.source, points)
    rows, at = rows_of(SQUARE, things, extra=3 * points)
    for thing, of_thing in zip(things, at):
        numbers = numpy.column_stack([SQUARE.places(thing.points[:, :2]), thing.points[:, 2]])
        rows[list(of_thing), -3 * points:] = numbers.ravel()
    return Example(SQUARE, [("output0", in_order(rows, order, kind, SQUARE, 4 + CLASSES))], things,
                   metadata={"task": "pose", "kpt_shape": f"[{points}, 3]"})


def ellipse(thing):
    """Whether places of the source picture are in the ellipse that fills the thing's box."""
    half = (thing.box[2:] - thing.box[:2]) / 2
    return lambda x, y: ((x - thing.centre[0]) / half[0]) ** 2 + ((y - thing.centre[1]) / half[1]) ** 2 < 1


def masked(order, kind, anchors, objectness):
    """Each prototype is one thing's ellipse on cells of 4 pixels, but the last, which is noise that no thing uses."""
    count, (width, height) = 8, (side // 4 for side in SQUARE.input)
    things = things_of(SQUARE.source)
    rows, at = rows_of(SQUARE, things, anchors, objectness, count)
    x, y = numpy.meshgrid(*((numpy.arange(side) + 0.5) * 4 for side in (width, height)))
    x, y = numpy.moveaxis(SQUARE.to_source(numpy.stack([x, y], axis=-1)), -1, 0)
    prototypes = numpy.random.default_rng(2).uniform(-1, 1, (count, height, width))
    for number, (thing, of_thing) in enumerate(zip(things, at)):
        prototypes[number] = numpy.where(ellipse(thing)(x, y), 6, -6)
        rows[list(of_thing), -count:] = numpy.eye(count)[number]
    form = prototypes if order == "planes" else prototypes.transpose(1, 2, 0)
    return Example(SQUARE, [("output0", in_order(rows, order, kind, SQUARE)), ("output1", form[None])], things,
                   metadata={"task": "segment"} if anchors == 1 else None, masks=[ellipse(thing) for thing in things])


def yolov8_seg(order, kind):
    return masked(order, kind, 1, False)


def yolov5_seg(order, kind):
    return masked(order, kind, 3, True)


def in_grids(order, version):
    """Three grids of logits. A thing is in the cell of its centre, at an anchor that is like it."""
    rng, view = numpy.random.default_rng(3), View((640, 480), (416, 416))
    things, outputs = things_of(view.source), []
    anchors = ANCHORS["yolov7" if version == "yolov7" else "yolov3"]
    for number, stride in enumerate(STRIDES):
        side = 416 // stride
        grid = rng.uniform(-2, 2, (3, 5 + CLASSES, side, side))
        grid[:, 4:] = rng.uniform(-8, -4, grid[:, 4:].shape)
        for thing in (thing for thing, of_thing in zip(things, OF_THING) if of_thing == stride):
            x, y, *size = view.centred(thing)
            sizes = numpy.array(anchors[3 * number:3 * number + 3])
            best = numpy.abs(numpy.log(sizes / size)).max(axis=1).argmin()
            (column, row), of_anchor = (int(x // stride), int(y // stride)), numpy.array(size) / sizes[best]
            inside = numpy.array([x / stride - column, y / stride - row])
            if version == "yolov3":
                numbers = [*logit(inside), *numpy.log(of_anchor)]
            else:
                numbers = [*logit((inside + 0.5) / 2), *logit(numpy.sqrt(of_anchor) / 2)]
            grid[best, :5, row, column] = [*numbers, logit(0.95)]
            grid[best, 5 + thing.index, row, column] = logit(thing.score / 0.95)
        forms = {"planes": grid.reshape(3 * (5 + CLASSES), side, side),
                 "rows": grid.transpose(2, 3, 0, 1).reshape(side, side, -1), "anchors": grid.transpose(0, 2, 3, 1)}
        outputs.append((f"grid{stride}", forms[order][None]))
    return Example(view, outputs, things, pixels={"float32": 0.05, "float16": 1, "uint8": 15, "int8": 15},
                   scores={"float32": 0.001, "float16": 0.004, "uint8": 0.04, "int8": 0.04})


def yolov3_grids(order, kind):
    return in_grids(order, "yolov3")


def yolov5_grids(order, kind):
    return in_grids(order, "yolov5")


def yolov7_grids(order, kind):
    return in_grids(order, "yolov7")


def end_to_end(order, kind, arrange, fill):
    """Rows of objects, then rows without."""
    things = things_of(SQUARE.source)
    unit = SQUARE.part if order == "parts" or kind == "uint8" else numpy.asarray
    rows = [arrange(unit(SQUARE.box(thing)), thing) for thing in things]
    return numpy.array(rows + [fill] * 20), things


def yolov10(order, kind):
    rows, things = end_to_end(order, kind, lambda box, thing: [*box, thing.score, thing.index], [0, 0, 0, 0, 0.01, 0])
    return Example(SQUARE, [("output0", rows[None])], things)


def yolov7_end2end(order, kind):
    rows, things = end_to_end(order, kind, lambda box, thing: [0, *box, thing.index, thing.score], [-1, 0, 0, 0, 0, 0, 0])
    return Example(SQUARE, [("output", rows[:3] if order == "pixels" else rows)], things)


def distribution(distance, bins=8):
    """Logits whose softmax has this mean (Li et al., "Generalized Focal Loss", 2020)."""
    low, weights = int(distance), numpy.full(bins, 1e-6)
    weights[low], weights[low + 1] = 1 - (distance - low) + 1e-6, distance - low + 1e-6
    return numpy.log(weights)


def nanodet(order, kind):
    """NanoDet-Plus, from the description of its authors: four grids of cells of 8 to 64 pixels whose places are the cells'
    corners; probabilities of 80 classes; distributions of the distances to the four edges, in cells."""
    view, strides, classes = View((640, 480), (320, 320)), (8, 16, 32, 64), 80
    rng, things, places = numpy.random.default_rng(4), things_of(view.source), cells(view.input, strides, True)
    rows = numpy.concatenate([rng.uniform(0, 0.15, (len(places), classes)), rng.uniform(-3, 3, (len(places), 32))], axis=1)
    for thing, stride in zip(things, OF_THING):
        at, box = cell_of(places, view.centred(thing)[:2], stride), view.box(thing)
        for row, less in ((at, 0), (at + 1, 0.1)):
            centre = places[row, :2] * stride
            distances = numpy.concatenate([centre - box[:2], box[2:] - centre]) / stride
            rows[row, classes:] = numpy.concatenate([distribution(distance) for distance in distances])
            rows[row, thing.index] = thing.score - less
    return Example(view, [("output", (rows if order == "rows" else rows.T)[None])], things,
                   pixels={"float32": 0.1, "float16": 1, "uint8": 12, "int8": 12})


def fastestdet(order, kind):
    """FastestDet, from the description of its author: one grid; objectness, tanh of the place in the cell, sigma of the size,
    probabilities of the classes; the score is objectness^0.6 x class^0.4."""
    view = View((640, 480), (352, 352))
    rng, things, side = numpy.random.default_rng(6), things_of(view.source), 352 // 16
    grid = rng.uniform(0, 0.15, (5 + CLASSES, side, side))
    grid[1:5] = rng.uniform(-2, 2, (4, side, side))
    for thing in things:
        x, y, *size = view.centred(thing) / 16
        column, row = int(x), int(y)
        grid[:5, row, column] = [0.95, *numpy.arctanh([x - column, y - row]), *logit(numpy.array(size) / side)]
        grid[5 + thing.index, row, column] = (thing.score / 0.95 ** 0.6) ** 2.5
    return Example(view, [("output", grid[None])], things, pixels={"float32": 0.05, "float16": 1, "uint8": 12, "int8": 12},
                   scores={"float32": 0.001, "float16": 0.004, "uint8": 0.06, "int8": 0.06})
