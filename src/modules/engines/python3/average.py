# SPDX-License-Identifier: LGPL-2.1-or-later
"""Example filter that declares its tensors: the mean of each channel of a picture; custom="CHANNELS WIDTH HEIGHT"."""

import numpy
from nnstreamer_python import TensorShape


class CustomFilter:
    def __init__(self, channels, width, height):
        self.channels = int(channels)
        self.input_dims = [TensorShape([self.channels, int(width), int(height), 1], numpy.uint8)]
        self.output_dims = [TensorShape([self.channels], numpy.float32)]

    def getInputDim(self):
        return self.input_dims

    def getOutputDim(self):
        return self.output_dims

    def invoke(self, input_array):
        pixels = input_array[0].reshape(-1, self.channels)
        return [pixels.mean(axis=0, dtype=numpy.float64).astype(numpy.float32)]
