# SPDX-License-Identifier: LGPL-2.1-or-later
"""A model of the soak test: passes the 64 numbers of a frame unchanged. The argument is the milliseconds that a frame takes."""

import time

import numpy
from weir import TensorShape


class CustomFilter:
    def __init__(self, milliseconds="0"):
        self.seconds = int(milliseconds) / 1000
        self.shapes = [TensorShape([64], numpy.int64)]

    def getInputDim(self):
        return self.shapes

    def getOutputDim(self):
        return self.shapes

    def invoke(self, input_array):
        time.sleep(self.seconds)
        return input_array
