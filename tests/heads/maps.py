# SPDX-License-Identifier: LGPL-2.1-or-later
"""Outputs of networks that give maps, classes and texts, written from what their authors publish.

DeepLab: Chen et al., 2018: scores of each class and pixel. DB: Liao et al., "Real-time Scene Text Detection with
Differentiable Binarization", 2020, section 3.4: regions grow by area x ratio / perimeter. CTC: Graves et al., "Connectionist
Temporal Classification", 2006, section 3.1: repetitions, then blanks are removed. Classifiers: the softmax of their logits.
"""

import numpy

from scene import Example, Thing, View

MAPS = View((640, 480), (320, 320))
BANDS = ((0.10, 0.10, 0.40, 0.60, 1), (0.50, 0.30, 0.90, 0.90, 3))  # parts of the source picture, and the class


def bands(view, cell):
    """The classes of cells of `cell` pixels of the input: two rectangles on class 0, and their boxes in the source."""
    classes = numpy.zeros((view.input[1] // cell, view.input[0] // cell), int)
    things = []
    for x1, y1, x2, y2, index in BANDS:
        box = numpy.rint(view.places(numpy.array([(x1, y1), (x2, y2)]) * view.source) / cell).astype(int)
        classes[box[0, 1]:box[1, 1], box[0, 0]:box[1, 0]] = index
        things.append(Thing(view.to_source(box * cell).ravel(), index, 1))
    return classes, things


def inside(thing):
    x1, y1, x2, y2 = thing.box
    return lambda x, y: (x > x1) & (x < x2) & (y > y1) & (y < y2)


def deeplab(order, kind):
    classes, things = bands(MAPS, 4)
    if order == "one class":
        classes, things = (classes == 3) * 1, things[1:]
        things[0].index = 1
        scores = numpy.random.default_rng(24).uniform(0.02, 0.4, (1, *classes.shape)) + 0.55 * (classes == 1)
    else:
        scores = numpy.random.default_rng(24).uniform(-4, 4, (21, *classes.shape))
        numpy.put_along_axis(scores, classes[None], 6, axis=0)
    form = scores if order == "planes" else scores.transpose(1, 2, 0)
    return Example(MAPS, [("ResizeBilinear_3", form[None])], things, map=classes, masks=[inside(thing) for thing in things])


def class_map(order, kind):
    classes, things = bands(MAPS, 4)
    return Example(MAPS, [("ArgMax", classes.astype(order)[None])], things, map=classes, masks=[inside(thing) for thing in things])


def depth(order, kind):
    """Inverse depths of a floor, as MiDaS gives them: Ranftl et al., 2020."""
    rows, columns = numpy.mgrid[0:64, 0:64]
    depths = 20 * rows + 3 * numpy.sin(columns / 5) + 5
    form = {"W:H": depths[None], "1:W:H": depths[None, :, :, None], "W:H:1": depths[None, None]}[order]
    return Example(View((640, 480), (256, 256)), [("output", form)], map=depths)


def classifier(order, kind):
    logits = numpy.random.default_rng(25).uniform(-4, 0, 10)
    logits[[7, 2]] = 5, 4
    scores = numpy.exp(logits) / numpy.exp(logits).sum()
    things = [Thing(None, int(index), scores[index]) for index in scores.argsort()[::-1] if scores[index] >= 0.1]
    return Example(View((640, 480), (224, 224)), [("output", (logits if order == "logits" else scores)[None])], things, map=scores)


def db(order, kind):
    """Two lines of text, one of them turned; the map has the shrunken regions, which the decoder grows."""
    view, ratio, rng = View((640, 480), (320, 320)), 1.5, numpy.random.default_rng(26)
    x, y = numpy.meshgrid(numpy.arange(320) + 0.5, numpy.arange(320) + 0.5)
    chances, things = rng.uniform(0, 0.2, (320, 320)), []
    for centre, size, angle in (((110, 100), (120, 16), 0.0), ((180, 210), (140, 20), 0.4 if order == "turned" else 0.0)):
        along = (x - centre[0]) * numpy.cos(angle) + (y - centre[1]) * numpy.sin(angle)
        across = (y - centre[1]) * numpy.cos(angle) - (x - centre[0]) * numpy.sin(angle)
        chances[(abs(along) < size[0] / 2) & (abs(across) < size[1] / 2)] = 0.9
        growth = size[0] * size[1] * ratio / (2 * (size[0] + size[1]))
        half = numpy.array(size) / 2 + growth
        centre = numpy.array(centre)
        things.append(Thing(view.to_source(numpy.array([centre - half, centre + half])).ravel(), 0, 0.9, angle))
    return Example(view, [("sigmoid_0.tmp_0", chances[None, None])], things,
                   pixels={kind: 4 for kind in ("float32", "float16", "uint8", "int8")})


def ctc(order, kind):
    """Steps of "hello, weir": the blank, class 0, separates the two letters l."""
    characters, text = "abcdefghijklmnopqrstuvwxyz,", "hello, weir"
    classes = {character: 1 + number for number, character in enumerate(characters)} | {" ": len(characters) + 1}
    steps = [0]
    for character in text:
        steps += [classes[character]] * (1 + len(steps) % 2) + [0]
    scores = numpy.full((len(steps), len(characters) + 2), 0.05 / (len(characters) + 1))
    scores[numpy.arange(len(steps)), steps] = 0.95
    if order.endswith("logits"):
        scores = numpy.log(scores) + 3
    form = scores[:, None] if order.startswith("CLASSES:1:STEPS") else scores[None]
    return Example(View((640, 96), (320, 48)), [("softmax_11.tmp_0" if order == "CLASSES:STEPS" else "output", form)],
                   text=text, labels=list(characters))
