# SPDX-License-Identifier: LGPL-2.1-or-later
"""Example filter: scales RGB pictures of any size to a given size, nearest pixel; custom="WIDTH HEIGHT"."""

import numpy
from nnstreamer_python import TensorShape


class CustomFilter:
    def __init__(self, width, height):
        self.width, self.height = int(width), int(height)

    def setInputDim(self, input_dims):
        channels, width, height, frames = input_dims[0].getDims()[:4]
        if frames > 1:
            raise ValueError(f"one picture at a time, not {frames}")
        self.shape = (height, width, channels)
        self.rows = numpy.arange(self.height) * height // self.height
        self.columns = numpy.arange(self.width) * width // self.width
        return [TensorShape([channels, self.width, self.height, 1], input_dims[0].getType())]

    def invoke(self, input_array):
        picture = input_array[0].reshape(self.shape)
        return [picture[self.rows[:, None], self.columns]]
