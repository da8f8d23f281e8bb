# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a picture shows, how a letterbox moves it into the input of a network, and the example of one head."""

import dataclasses

import numpy


@dataclasses.dataclass
class Thing:
    """An object that a network is to find. Positions are pixels of the source picture."""
    box: numpy.ndarray  # x1, y1, x2, y2
    index: int
    score: float
    rotation: float = 0.0  # clockwise, in radians
    points: numpy.ndarray = None  # rows of x, y, score

    @property
    def centre(self):
        return (self.box[:2] + self.box[2:]) / 2


@dataclasses.dataclass
class View:
    """A letterbox: the source picture fills the input as far as its proportions allow, in the middle."""
    source: tuple  # width, height
    input: tuple

    @property
    def scale(self):
        return min(self.input[0] / self.source[0], self.input[1] / self.source[1])

    @property
    def corner(self):
        return (numpy.array(self.input) - numpy.array(self.source) * self.scale) / 2

    def places(self, places):
        """Pixels of the input, for rows of x, y of the source picture."""
        return numpy.asarray(places, float) * self.scale + self.corner

    def box(self, thing):
        return numpy.concatenate([self.places(thing.box[:2]), self.places(thing.box[2:])])

    def centred(self, thing):
        """Centre and size in pixels of the input."""
        box = self.box(thing)
        return numpy.concatenate([(box[:2] + box[2:]) / 2, box[2:] - box[:2]])

    def part(self, numbers):
        """x, y, x, y, ... as parts of the input."""
        numbers = numpy.asarray(numbers, float)
        return numbers / numpy.resize(numpy.array(self.input, float), numbers.shape[-1])

    def to_source(self, places):
        return (numpy.asarray(places, float) - self.corner) / self.scale


@dataclasses.dataclass
class Example:
    """Outputs of a network of one head for a picture, and what is in the picture."""
    view: View
    outputs: list  # pairs of name and array
    things: list = dataclasses.field(default_factory=list)
    custom: str = ""  # settings that the head needs, besides its name
    properties: str = ""  # of tensor_decoder
    labels: list = None
    metadata: dict = None  # of the model's file
    pixels: dict = dataclasses.field(default_factory=lambda: {"float32": 0.05, "float16": 1, "uint8": 6, "int8": 6})
    scores: dict = dataclasses.field(default_factory=lambda: {"float32": 0.001, "float16": 0.004, "uint8": 0.03, "int8": 0.03})
    map: numpy.ndarray = None  # classes or depths of the pixels of the input
    masks: list = None  # of each thing: a function of x, y of the source picture
    text: str = ""


# Parts of the source picture, index and score. The sizes are those of three grids.
THINGS = (((0.10, 0.15, 0.45, 0.70), 2, 0.90), ((0.55, 0.35, 0.80, 0.85), 0, 0.80), ((0.60, 0.08, 0.72, 0.22), 1, 0.70))


def things_of(source, points=0, count=3, rng=None):
    found = []
    for box, index, score in THINGS[:count]:
        thing = Thing(numpy.array(box) * numpy.tile(source, 2), index, score)
        if points:
            rng = rng or numpy.random.default_rng(5)
            inside = rng.uniform(0.1, 0.9, (points, 2)) * (thing.box[2:] - thing.box[:2]) + thing.box[:2]
            thing.points = numpy.column_stack([inside, rng.uniform(0.6, 0.95, points)])
        found.append(thing)
    return found


def logit(probability):
    probability = numpy.asarray(probability, float)
    return numpy.log(probability / (1 - probability))


def sigmoid(number):
    return 1 / (1 + numpy.exp(-numpy.asarray(number, float)))


def cells(size, strides, rounds_up=False):
    """Column, row and stride of each cell, the grid of the smallest cells first."""
    found = []
    for stride in strides:
        columns, rows = (-(-side // stride) if rounds_up else side // stride for side in size)
        found += [(column, row, stride) for row in range(rows) for column in range(columns)]
    return numpy.array(found)


def cell_of(places, centre, stride):
    """The number of the cell of this stride in which a place is."""
    column, row = (numpy.asarray(centre) // stride).astype(int)
    return int(numpy.flatnonzero((places == (column, row, stride)).all(axis=1))[0])
