# SPDX-License-Identifier: LGPL-2.1-or-later
"""Outputs of networks that find key points, written from what their authors publish.

MediaPipe: the model cards of hand, face and pose landmarks: points in pixels of the input; Bazarevsky et al., "BlazePose",
2020. MoveNet: its pages on TensorFlow Hub: y, x and score as parts of the input. PoseNet: Papandreou et al., "PersonLab",
2018: logits of heat maps, offsets and displacements in pixels. Heat maps: Sun et al., "HRNet", 2019: Gaussians of a
deviation of 2 cells; a peak is a quarter of a cell nearer to its higher neighbour.
"""

import numpy

from scene import Example, Thing, View, logit, things_of

# PersonLab's skeleton: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles, left before right.
CHAIN = [(0, 1), (1, 3), (0, 2), (2, 4), (0, 5), (5, 7), (7, 9), (5, 11), (11, 13), (13, 15), (0, 6), (6, 8), (8, 10), (6, 12),
         (12, 14), (14, 16)]
BODY = numpy.array([(.5, .08), (.56, .05), (.44, .05), (.63, .07), (.37, .07), (.72, .25), (.28, .25), (.85, .40), (.15, .40),
                    (.95, .55), (.05, .55), (.64, .55), (.36, .55), (.66, .77), (.34, .77), (.68, .97), (.32, .97)])


def around(thing, least):
    """The thing with the upright box around its points of at least this score."""
    places = thing.points[thing.points[:, 2] >= least][:, :2]
    thing.box = numpy.concatenate([places.min(axis=0), places.max(axis=0)])
    thing.index = 0
    return thing


def body(source, box, scores, score=None):
    box = numpy.array(box) * numpy.tile(source, 2)
    points = numpy.column_stack([BODY * (box[2:] - box[:2]) + box[:2], scores])
    return Thing(box, 0, float(numpy.mean(scores)) if score is None else score, points=points)


def scores_of(count, seed):
    return numpy.random.default_rng(seed).uniform(0.55, 0.95, count)


def blazepose(order, kind):
    """39 points of x, y, z and the logits of visibility and presence; 33 of them are of the body."""
    view = View((640, 480), (256, 256))
    thing, = things_of(view.source, 33, 1)
    numbers = numpy.zeros((39, 5))
    numbers[:33, :2] = view.places(thing.points[:, :2])
    numbers[:33, 3] = logit(thing.points[:, 2])
    numbers[33:] = numpy.random.default_rng(12).uniform(0, 250, (6, 5))
    points = numbers if order == "195" else numbers[:33, :4] if order == "132" else numbers[:33] if order == "165" else numbers[:, :4]
    return Example(view, [("Identity", points.reshape(1, -1)), ("Identity_1", numpy.array([[thing.score]]))], [around(thing, 0.5)])


def hand_landmarks(order, kind):
    """21 points of x, y, z, the probabilities of a hand and of a right one, and the points in metres, which are not read."""
    view = View((640, 480), (224, 224))
    thing, = things_of(view.source, 21, 1)
    thing.points[:, 2] = thing.score
    numbers = numpy.zeros((21, 3))
    numbers[:, :2] = view.places(thing.points[:, :2])
    world = numpy.random.default_rng(13).uniform(-0.1, 0.1, (1, 63))
    around(thing, 0.5).index = 1 if order == "right" else 0
    side = 0.97 if order == "right" else 0.02
    return Example(view, [("Identity", numbers.reshape(1, -1)), ("Identity_1", numpy.array([[thing.score]])),
                          ("Identity_2", numpy.array([[side]])), ("Identity_3", world)], [thing])


def face_landmarks(order, kind):
    """468 points, or 478 with those of the irises, of x, y, z; the logit of a face."""
    view, count = View((640, 480), (192, 192)), int(order)
    thing, = things_of(view.source, count, 1)
    thing.points[:, 2] = thing.score
    numbers = numpy.zeros((count, 3))
    numbers[:, :2] = view.places(thing.points[:, :2])
    return Example(view, [("conv2d_20", numbers.reshape(1, 1, 1, -1)), ("conv2d_30", logit(thing.score).reshape(1, 1, 1, 1))],
                   [around(thing, 0.5)])


def movenet(order, kind):
    view = View((640, 480), (192, 192))
    thing = body(view.source, (0.2, 0.1, 0.7, 0.9), scores_of(17, 14))
    places = view.part(view.places(thing.points[:, :2]))
    return Example(view, [("output_0", numpy.column_stack([places[:, 1], places[:, 0], thing.points[:, 2]])[None, None])],
                   [around(thing, 0.2)], pixels={"float32": 0.05, "float16": 1, "uint8": 3, "int8": 3})


def movenet_multipose(order, kind):
    """Six persons of 17 points, and y1, x1, y2, x2 and score of their boxes."""
    view = View((640, 480), (256, 256))
    things = [body(view.source, (0.05, 0.1, 0.4, 0.9), scores_of(17, 15), 0.9),
              body(view.source, (0.55, 0.2, 0.95, 0.95), scores_of(17, 16), 0.6)]
    persons = numpy.random.default_rng(17).uniform(0, 0.15, (6, 56))
    for row, thing in zip((0, 3), things):
        places, box = view.part(view.places(thing.points[:, :2])), view.part(view.box(thing))
        persons[row, :51] = numpy.column_stack([places[:, 1], places[:, 0], thing.points[:, 2]]).ravel()
        persons[row, 51:] = [box[1], box[0], box[3], box[2], thing.score]
    return Example(view, [("output_0", persons[None])], things, pixels={"float32": 0.05, "float16": 1, "uint8": 3, "int8": 3})


def posenet(order, kind):
    """15 x 15 cells from the first to the last pixel."""
    view, side, stride = View((450, 270), (225, 225)), 15, 16
    boxes = [(0.03, 0.05, 0.45, 0.95), (0.55, 0.05, 0.97, 0.95)][:1 if order == "one" else 2]
    things = [body(view.source, box, scores_of(17, 18 + number)) for number, box in enumerate(boxes)]
    rng = numpy.random.default_rng(20)
    heat, offsets = rng.uniform(-6, -3, (side, side, 17)), rng.uniform(-8, 8, (side, side, 34))
    forward, backward = numpy.zeros((2, side, side, 32))
    for thing in things:
        places = view.places(thing.points[:, :2])
        at = numpy.rint(places / stride).astype(int)
        for point in range(17):
            column, row = at[point]
            heat[row, column, point] = logit(thing.points[point, 2])
            for offset, axis in ((point, 1), (17 + point, 0)):
                # The neighbours too: the decoder follows vectors that end beside a cell's middle.
                for y, x in ((row + b, column + a) for a in (-1, 0, 1) for b in (-1, 0, 1)):
                    if 0 <= x < side and 0 <= y < side:
                        offsets[y, x, offset] = places[point][axis] - (x, y)[axis] * stride
        for edge, (parent, child) in enumerate(CHAIN):
            for values, start, end in ((forward, parent, child), (backward, child, parent)):
                column, row = at[start]
                values[row, column, [edge, 16 + edge]] = (places[end] - places[start])[::-1]
        around(thing, 0.25)
    outputs = [("heatmap", heat[None]), ("offset_2", offsets[None])]
    if order == "two":
        outputs += [("displacement_fwd_2", forward[None]), ("displacement_bwd_2", backward[None])]
    if order == "joined":
        outputs += [("displacements", numpy.concatenate([forward, backward], axis=2)[None])]
    return Example(view, outputs, things, pixels={"float32": 0.05, "float16": 1, "uint8": 3, "int8": 3})


def heat_maps(order, kind):
    """17 maps of a quarter of the input's sides; each point is a quarter of a cell off the middle of its cell."""
    view, width, height = View((600, 400), (192, 256)), 48, 64
    thing = body(view.source, (0.2, 0.1, 0.8, 0.9), scores_of(17, 21))
    at = numpy.rint(view.places(thing.points[:, :2]) / 4).clip(2, (width - 3, height - 3))
    places = at + numpy.random.default_rng(22).choice((-0.25, 0.25), (17, 2))
    x, y = numpy.meshgrid(numpy.arange(width), numpy.arange(height))
    maps = numpy.array([numpy.exp(-((x - of_x) ** 2 + (y - of_y) ** 2) / 8) for of_x, of_y in places])
    maps *= (thing.points[:, 2] / maps.max(axis=(1, 2)))[:, None, None]
    maps += numpy.random.default_rng(23).uniform(0, 1e-4, maps.shape)
    thing.points[:, :2] = view.to_source(places * 4)
    return Example(view, [("output", (maps if order == "planes" else maps.transpose(1, 2, 0))[None])], [around(thing, 0.2)])
