# SPDX-License-Identifier: LGPL-2.1-or-later
"""The three networks of examples/ars in PyTorch, and how their weights are written for the pipeline."""

import numpy as np
import torch
from torch import nn

EVENT_FRAMES, RESULTS, RESPONSES = 8, 12, 75  # in a window of the event network, of the LSTM, of the radio network
CHANNELS = (32, 64, 96, 96)  # of the event network's convolutions
STRIDES = (2, 2, 1, 2)
HIDDEN = 256  # of each of the LSTM's two layers
OPSET = 11


def convolution(inputs, outputs, stride):
    return nn.Sequential(nn.Conv2d(inputs, outputs, 3, stride, padding=1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU())


class EventNetwork(nn.Module):
    """Windows [batch, 8, 48, 64] of event frames in, a logit for each activity out."""

    def __init__(self, activities):
        super().__init__()
        inputs = (EVENT_FRAMES, *CHANNELS)
        self.features = nn.Sequential(*(convolution(*one) for one in zip(inputs, CHANNELS, STRIDES)))
        self.classify = nn.Linear(2 * CHANNELS[-1], activities)

    def forward(self, windows):
        features = self.features(windows).flatten(2)
        return self.classify(torch.cat([features.mean(2), features.amax(2)], dim=1))


class SequenceNetwork(nn.Module):
    """Windows [batch, 12, activities] of the event network's probabilities in, logits out."""

    def __init__(self, activities):
        super().__init__()
        self.lstm = nn.LSTM(activities, HIDDEN, 2, batch_first=True)
        self.classify = nn.Linear(HIDDEN, activities)

    def forward(self, windows):
        return self.classify(self.lstm(windows)[0][:, -1])


class RadioNetwork(nn.Module):
    """Windows [batch, 2, 75, 32] of standardised responses of two radios in, logits out."""

    def __init__(self, activities):
        super().__init__()
        self.features = nn.Sequential(convolution(2, 48, 1), nn.MaxPool2d(2), convolution(48, 96, 1), convolution(96, 96, 1), nn.MaxPool2d(2),
                                      convolution(96, 128, 1), nn.MaxPool2d(2), convolution(128, 128, 1))
        self.classify = nn.Linear(2 * 128, activities)

    def forward(self, windows):
        features = self.features(windows).flatten(2)
        return self.classify(torch.cat([features.mean(2), features.amax(2)], dim=1))


class Probabilities(nn.Module):
    """A network as it is shipped: probabilities instead of logits."""

    def __init__(self, network):
        super().__init__()
        self.network = network

    def forward(self, windows):
        return torch.softmax(self.network(windows), dim=1)


def folded(layer):
    """The weights [3, 3, inputs, outputs] and the bias of a convolution with its batch normalisation."""
    weights, norm = layer[0].weight, layer[1]
    factor = norm.weight / torch.sqrt(norm.running_var + norm.eps)
    return (weights * factor[:, None, None, None]).permute(2, 3, 1, 0), norm.bias - norm.running_mean * factor


def write_weights(path, arrays, dtype):
    """Numbers in little-endian order, one array after the other, as event_network.cpp and sequence_network.cpp read them."""
    with open(path, "wb") as file:
        for array in arrays:
            file.write(array.detach().numpy().astype(dtype, order="C").tobytes())


def export_event_network(network, path):
    """For each convolution its weights and bias; the classifier's weights [inputs, activities] and bias."""
    arrays = [array for layer in network.features for array in folded(layer)]
    write_weights(path, [*arrays, network.classify.weight.T, network.classify.bias], "<f4")


def export_sequence_network(network, path):
    """For each layer the weights [inputs + HIDDEN, 4 * HIDDEN] of the gates in, forget, cell, out, and their bias; the classifier as above. In float16."""
    arrays = []
    for of_inputs, of_hidden, bias, other_bias in network.lstm.all_weights:
        arrays += [torch.cat([of_inputs, of_hidden], dim=1).T, bias + other_bias]
    write_weights(path, [*arrays, network.classify.weight.T, network.classify.bias], "<f2")


def export_radio_network(network, path):
    torch.onnx.export(Probabilities(network).eval(), torch.zeros(1, 2, RESPONSES, 32), str(path), opset_version=OPSET,
                      input_names=["responses"], output_names=["probabilities"])


def make_windows(frames, length, step):
    """Windows of `length` frames, each `step` after the one before: [windows, length, ...]."""
    return np.stack([frames[begin:begin + length] for begin in range(0, len(frames) - length + 1, step)])
