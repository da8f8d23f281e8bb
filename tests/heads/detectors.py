# SPDX-License-Identifier: LGPL-2.1-or-later
"""Outputs of SSD, of detection transformers and of face, palm and person detectors, written from what their authors publish.

SSD: Liu et al., "SSD: Single Shot MultiBox Detector", 2016, section 2.2, with the values of TensorFlow's configuration of
SSD MobileNet v1. DETR: Carion et al., 2020. RT-DETR: Zhao et al., 2023. DetectionOutput: the operator's page in OpenVINO's
documentation. TFLite_Detection_PostProcess: TensorFlow's documentation of object detection on mobile devices.
YuNet: Wu et al., "YuNet: A Tiny Millisecond-level Face Detector", 2023. UltraFace: the description of
Ultra-Light-Fast-Generic-Face-Detector-1MB. MediaPipe: the graphs of face, palm and pose detection, whose anchors are the
centres of cells, two for each layer, and Bazarevsky et al., "BlazeFace", 2019.
"""

import numpy

from scene import Example, View, cell_of, cells, logit, things_of

CLASSES = 5
SQUARE = View((640, 480), (320, 320))


def of_rows(view, things, order, numbers, classes):
    """Boxes as centre and size, parts of the picture, among rows that are no object."""
    rng = numpy.random.default_rng(7)
    boxes, scores = rng.uniform(0.1, 0.9, (numbers, 4)), rng.uniform(-9, -4, (numbers, classes))
    for row, thing in zip((5, 40, 17), things):
        boxes[row] = view.part(view.centred(thing))
    return boxes, scores


def detr(order, kind):
    """The softmax of the logits; the last logit means no object."""
    things = things_of(SQUARE.source)
    boxes, scores = of_rows(SQUARE, things, order, 100, CLASSES + 1)
    scores[:, -1] = 6
    for row, thing in zip((5, 40, 17), things):
        others = 1e-4
        scores[row] = numpy.log(others)
        scores[row, thing.index] = numpy.log(thing.score)
        scores[row, -1] = numpy.log(1 - thing.score - (CLASSES - 1) * others)
    outputs = [("logits", scores[None]), ("pred_boxes", boxes[None])]
    return Example(SQUARE, outputs if order == "logits first" else outputs[::-1], things)


def rtdetr(order, kind):
    """Logits of each class and boxes, in two outputs; or probabilities after the boxes, in one."""
    things = things_of(SQUARE.source)
    boxes, scores = of_rows(SQUARE, things, order, 300, CLASSES)
    for row, thing in zip((5, 40, 17), things):
        scores[row, thing.index] = logit(thing.score)
    if order == "joined":
        return Example(SQUARE, [("output0", numpy.concatenate([boxes, 1 / (1 + numpy.exp(-scores))], axis=1)[None])], things)
    outputs = [("logits", scores[None]), ("pred_boxes", boxes[None])]
    return Example(SQUARE, outputs if order == "logits first" else outputs[::-1], things)


def labels_boxes_scores(order, kind):
    """Pixels and numbers of classes; the rows after the objects are less certain. With two outputs, each box ends in its score."""
    things = things_of(SQUARE.source)
    boxes = numpy.zeros((30, 4))
    boxes[:3] = [SQUARE.box(thing) for thing in things]
    labels = numpy.zeros(30, "i8")
    labels[:3] = [thing.index for thing in things]
    scores = numpy.full(30, 0.2)
    scores[:3] = [thing.score for thing in things]
    of_one_scale = SQUARE.part(boxes) if kind in ("uint8", "int8") else boxes
    outputs = {"labels": labels, "boxes": boxes, "scores": scores, "dets": numpy.column_stack([of_one_scale, scores])}
    return Example(SQUARE, [(name, outputs[name]) for name in order.split(",")], things)


def detection_output(order, kind):
    """Rows of picture, class, score and corners; a picture of -1 ends them."""
    things = things_of(SQUARE.source)
    unit = SQUARE.part if order == "parts" or kind in ("uint8", "int8") else numpy.asarray
    rows = [[0, thing.index, thing.score, *unit(SQUARE.box(thing))] for thing in things]
    rows += [[0, 1, 0.3, *unit(SQUARE.box(things[0]))], [-1] + [0] * 6, [0, 1, 0.99, *unit(SQUARE.box(things[0]))]]
    return Example(SQUARE, [("detection_out", numpy.array(rows)[None, None])], things)


def ssd_anchors():
    """Of 300 x 300 pixels: grids of 19 to 1 cells; scales 0.2 to 0.95; ratios 1, 2, 1/2, 3, 1/3; in the first grid three."""
    scales = [0.2 + 0.75 * number / 5 for number in range(6)] + [1.0]
    found = []
    for number, side in enumerate((19, 10, 5, 3, 2, 1)):
        if number == 0:
            shapes = [(0.1, 1.0), (0.2, 2.0), (0.2, 0.5)]
        else:
            shapes = [(scales[number], ratio) for ratio in (1.0, 2.0, 0.5, 3.0, 1 / 3)]
            shapes.append(((scales[number] * scales[number + 1]) ** 0.5, 1.0))
        found += [((row + 0.5) / side, (column + 0.5) / side, scale / ratio ** 0.5, scale * ratio ** 0.5)
                  for row in range(side) for column in range(side) for scale, ratio in shapes]
    return numpy.array(found)  # y, x, height, width


def ssd(order, kind):
    """Distances to anchors: 10 times of the centre, 5 times the logarithm of the size. Class 0 is the background."""
    view, rng, anchors = View((600, 400), (300, 300)), numpy.random.default_rng(8), ssd_anchors()
    things = things_of(view.source)
    boxes, scores = rng.uniform(-2, 2, (len(anchors), 4)), rng.uniform(-9, -4, (len(anchors), CLASSES + 1))
    for thing in things:
        x, y, width, height = view.part(view.centred(thing))
        apart = numpy.abs(anchors - (y, x, height, width)).sum(axis=1)
        for anchor, less in zip(apart.argsort()[:2], (0, 0.1)):
            of_y, of_x, of_height, of_width = anchors[anchor]
            boxes[anchor] = [10 * (y - of_y) / of_height, 10 * (x - of_x) / of_width, 5 * numpy.log(height / of_height),
                             5 * numpy.log(width / of_width)]
            scores[anchor, thing.index + 1] = logit(thing.score - less)
        thing.index += 1
    outputs = [("boxes", boxes[:, None]), ("scores", scores)]
    return Example(view, outputs if order == "boxes first" else outputs[::-1], things)


def ssd_postprocess(order, kind):
    """Corners as y1, x1, y2, x2, parts of the picture; the count says how many rows there are."""
    things = things_of(SQUARE.source)
    boxes, classes, scores = numpy.zeros((10, 4)), numpy.zeros(10), numpy.zeros(10)
    for row, thing in enumerate(things):
        boxes[row] = SQUARE.part(SQUARE.box(thing))[[1, 0, 3, 2]]
        classes[row], scores[row] = thing.index, thing.score
    boxes[3], classes[3], scores[3] = boxes[0], 1, 0.95  # after the end
    outputs = {"boxes": boxes[None], "classes": classes[None], "scores": scores[None], "count": numpy.array([3.0])}
    return Example(SQUARE, [(f"detection_{name}" if order.startswith("scores") else f"TFLite_Detection_PostProcess:{name}", outputs[name])
                            for name in order.split(",")], things,
                   custom="first-class:0" if order.startswith("scores") else "")


def yunet(order, kind):
    """For each grid: probabilities of class and object, centre and logarithm of the size in cells, five points in cells."""
    view, rng = View((640, 480), (320, 320)), numpy.random.default_rng(9)
    things, outputs = things_of(view.source, 5), {}
    for stride, thing in zip((32, 16, 8), things):
        places = cells(view.input, (stride,))
        faces, objects = rng.uniform(0, 0.4, (2, len(places), 1))
        boxes, points = rng.uniform(-1, 1, (len(places), 4)), rng.uniform(-1, 1, (len(places), 10))
        x, y, *size = view.centred(thing)
        first = cell_of(places, (x, y), stride)
        for row, less in ((first, 0), (first + 1, 0.05)):
            faces[row], objects[row] = thing.score - less, thing.score - less
            boxes[row] = [*(numpy.array([x, y]) / stride - places[row, :2]), *numpy.log(numpy.array(size) / stride)]
            points[row] = (view.places(thing.points[:, :2]) / stride - places[row, :2]).ravel()
        thing.points[:, 2] = thing.score
        outputs |= {f"cls_{stride}": faces, f"obj_{stride}": objects, f"bbox_{stride}": boxes, f"kps_{stride}": points}
    for thing in things:
        thing.index = 0
    names = [f"{part}_{stride}" for part in ("cls", "obj", "bbox", "kps") for stride in (8, 16, 32)]
    return Example(view, [(name, outputs[name][None]) for name in (names if order == "by kind" else sorted(names))], things,
                   pixels={"float32": 0.05, "float16": 1, "uint8": 12, "int8": 12})


def ultraface_priors(width, height):
    """Centres of cells and squares of these sides, as parts of the picture, at most 1."""
    found = []
    for stride, sides in ((8, (10, 16, 24)), (16, (32, 48)), (32, (64, 96)), (64, (128, 192, 256))):
        found += [((column + 0.5) * stride / width, (row + 0.5) * stride / height, side / width, side / height)
                  for row in range(-(-height // stride)) for column in range(-(-width // stride)) for side in sides]
    return numpy.array(found).clip(0, 1)


def of_ultraface(order, is_raw):
    view, rng = View((640, 320), (320, 240)), numpy.random.default_rng(10)
    things, priors = things_of(view.source), ultraface_priors(*view.input)
    scores = rng.uniform(0, 0.4, (len(priors), 2))
    centred = numpy.tile(priors, 1)
    for thing in things:
        thing.index = 0
        wanted = view.part(view.centred(thing))
        for row, less in zip(numpy.abs(priors - wanted).sum(axis=1).argsort()[:2], (0, 0.02)):
            centred[row], scores[row, 1] = wanted, thing.score - less
    scores[:, 0] = 1 - scores[:, 1]
    if is_raw:  # variances 0.1 and 0.2
        boxes = numpy.concatenate([(centred[:, :2] - priors[:, :2]) / priors[:, 2:] / 0.1,
                                   numpy.log(centred[:, 2:] / priors[:, 2:]) / 0.2], axis=1)
    else:
        boxes = numpy.concatenate([centred[:, :2] - centred[:, 2:] / 2, centred[:, :2] + centred[:, 2:] / 2], axis=1)
    names = ("Identity", "Identity_1") if is_raw else ("scores", "boxes")
    outputs = [(names[0], scores[None]), (names[1], boxes[None])]
    return Example(view, outputs if order == "scores first" else outputs[::-1], things, properties="threshold=0.65",
                   pixels={"float32": 0.05, "float16": 1, "uint8": 10, "int8": 10})


def ultraface(order, kind):
    return of_ultraface(order, False)


def ultraface_raw(order, kind):
    return of_ultraface(order, True)


def mediapipe(view, grids, points, order, things):
    """Pixels relative to the centre of a cell: centre, size, points; the scores are logits. `grids`: stride and anchors of
    each cell."""
    rng, side = numpy.random.default_rng(11), view.input[0]
    anchors = numpy.array([((column + 0.5) * stride, (row + 0.5) * stride) for stride, count in grids
                           for row in range(side // stride) for column in range(side // stride) for _ in range(count)])
    boxes, scores = rng.uniform(-20, 20, (len(anchors), 4 + 2 * points)), rng.uniform(-9, -3, (len(anchors), 1))
    for thing in things:
        thing.index = 0
        centred = view.centred(thing)
        for row, less in zip(numpy.hypot(*(anchors - centred[:2]).T).argsort(kind="stable")[:2], (0, 0.1)):
            boxes[row, :2], boxes[row, 2:4] = centred[:2] - anchors[row], centred[2:]
            boxes[row, 4:] = (view.places(thing.points[:, :2]) - anchors[row]).ravel()
            scores[row] = logit(thing.score - less)
        thing.points[:, 2] = thing.score
    outputs = [("regressors", boxes[None]), ("classificators", scores[None])]
    return Example(view, outputs if order.endswith("boxes first") else outputs[::-1], things)


def blazeface(order, kind):
    side, grids = {"short": (128, ((8, 2), (16, 6))), "back": (256, ((16, 2), (32, 6))), "full": (192, ((4, 1),))}[order.split()[0]]
    view = View((640, 480), (side, side))
    return mediapipe(view, grids, 6, order, things_of(view.source, 6))


def towards(start, end):
    """The rotation of MediaPipe's rectangles whose target angle is 90 degrees: 0 is upwards."""
    return numpy.pi / 2 - numpy.arctan2(-(end[1] - start[1]), end[0] - start[0])


def palm_detection(order, kind):
    """A palm is turned like the line from its wrist, point 0, to the joint of its middle finger, point 2."""
    side, grids = {"192": (192, ((8, 2), (16, 6))), "256": (256, ((8, 2), (16, 2), (32, 6)))}[order.split()[0]]
    view = View((640, 480), (side, side))
    things = things_of(view.source, 7)
    for thing in things:
        thing.rotation = towards(thing.points[0, :2], thing.points[2, :2])
    return mediapipe(view, grids, 7, order, things)


def blazepose_detection(order, kind):
    """A person is the square around point 0, the middle of the hips, whose circle goes through point 1."""
    side, grids = {"224": (224, ((8, 2), (16, 2), (32, 6))), "128": (128, ((8, 2), (16, 6)))}[order.split()[0]]
    view = View((640, 480), (side, side))
    example = mediapipe(view, grids, 4, order, things_of(view.source, 4))
    for thing in example.things:
        reach = numpy.hypot(*(thing.points[1, :2] - thing.points[0, :2]))
        thing.rotation = towards(thing.points[0, :2], thing.points[1, :2])
        thing.box = numpy.concatenate([thing.points[0, :2] - reach, thing.points[0, :2] + reach])
    return example
