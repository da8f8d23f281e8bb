# SPDX-License-Identifier: LGPL-2.1-or-later
"""The networks of examples/ars in NumPy from their definitions, and a decoder of Event Stream files: what tests compare with."""

import numpy

STRIDES = (2, 2, 1, 2)
CHANNELS = (8, 32, 64, 96, 96)


def parts_of(path, *shapes, dtype="<f4"):
    """The arrays of a file of numbers."""
    numbers, at, arrays = numpy.fromfile(path, dtype).astype(numpy.float64), 0, []
    for shape in shapes:
        count = int(numpy.prod(shape))
        arrays.append(numbers[at:at + count].reshape(shape))
        at += count
    assert at == len(numbers), f"{path}: {len(numbers)} numbers, {at} needed"
    return arrays


def softmax(values):
    powers = numpy.exp(values - values.max())
    return powers / powers.sum()


def convolve(maps, weights, bias, stride):
    """[height, width, channels] by [3, 3, channels, outputs], with a border of zeros; then ReLU."""
    padded = numpy.pad(maps, ((1, 1), (1, 1), (0, 0)))
    patches = numpy.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(0, 1))[::stride, ::stride]
    return numpy.maximum(numpy.einsum("yxckl,klco->yxo", patches, weights) + bias, 0)


def event_network(path, window):
    """The probabilities for a window [8, 48, 64]."""
    shapes = [shape for i, o in zip(CHANNELS, CHANNELS[1:]) for shape in ((3, 3, i, o), (o,))]
    *layers, classifier, bias = parts_of(path, *shapes, (2 * CHANNELS[-1], 5), (5,))
    maps = window.transpose(1, 2, 0).astype(numpy.float64)
    for weights, of_layer, stride in zip(layers[::2], layers[1::2], STRIDES):
        maps = convolve(maps, weights, of_layer, stride)
    return softmax(numpy.concatenate([maps.mean(axis=(0, 1)), maps.max(axis=(0, 1))]) @ classifier + bias)


def sequence_network(path, window, hidden=256):
    """The probabilities for 12 results [12, 5]: an LSTM of two layers with gates in, forget, cell, out."""
    shapes = [shape for inputs in (5, hidden) for shape in ((inputs + hidden, 4 * hidden), (4 * hidden,))]
    *layers, classifier, of_classes = parts_of(path, *shapes, (hidden, 5), (5,), dtype="<f2")

    def sigmoid(x):
        return 1 / (1 + numpy.exp(-x))

    states = window
    for weights, bias in zip(layers[::2], layers[1::2]):
        state, cell, inputs, states = numpy.zeros(hidden), numpy.zeros(hidden), states, []
        for one in inputs:
            enter, forget, new, leave = numpy.split(numpy.concatenate([one, state]) @ weights + bias, 4)
            cell = sigmoid(forget) * cell + sigmoid(enter) * numpy.tanh(new)
            state = sigmoid(leave) * numpy.tanh(cell)
            states.append(state)
    return softmax(state @ classifier + of_classes)


def event_frames(data, rate):
    """Complete frames of an Event Stream file of DVS events: uint8 [frames, 48, 64]."""
    width, height = (int.from_bytes(data[at:at + 2], "little") for at in (16, 18))
    time, at, frames = 0, 20, []
    while at < len(data):
        if data[at] == 0xff:
            time, at = time + 127, at + 1
        elif data[at] == 0xfe:
            at += 1
        elif at + 5 > len(data):
            break
        else:
            time += data[at] >> 1
            x, y = (int.from_bytes(data[at + place:at + place + 2], "little") for place in (1, 3))
            while len(frames) <= time * rate // 1_000_000:
                frames.append(numpy.zeros((48, 64), int))
            frames[-1][y * 48 // height, x * 64 // width] += 1 if data[at] & 1 else -1
            at += 5
    return numpy.clip(128 + 16 * numpy.array(frames[:-1]), 0, 255).astype(numpy.uint8)
