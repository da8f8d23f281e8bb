# SPDX-License-Identifier: LGPL-2.1-or-later
"""Example script for tensor_converter: the histogram of each buffer's bytes, as 256 counts."""

import numpy
from nnstreamer_python import TensorShape


class CustomConverter:
    def convert(self, input_array):
        counts = sum(numpy.bincount(array, minlength=256) for array in input_array).astype(numpy.uint32)
        return [TensorShape([256], numpy.uint32)], [counts.view(numpy.uint8)], 0, 1
