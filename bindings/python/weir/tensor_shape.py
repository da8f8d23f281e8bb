# SPDX-License-Identifier: LGPL-2.1-or-later
"""A tensor's dimensions and type, as scripts of tensor_filter and tensor_converter say them."""

import numpy

MOST_DIMENSIONS = 16


class TensorShape:
    """Dimensions innermost first, with zeros up to 16, and the type of the elements.

    `dims` is a list of the shape's own: changes of the list that was given do not change it.
    """

    def __init__(self, dims=None, type=numpy.uint8):  # the name of the argument is NNStreamer's
        self.setDims([] if dims is None else dims)
        self.type = numpy.dtype(type)

    def setDims(self, dims):
        if not isinstance(dims, list):
            raise TypeError(f"the dimensions of a TensorShape are a list, not {type(dims).__name__}")
        own = list.copy(dims)
        if len(own) > MOST_DIMENSIONS:
            raise ValueError(f"{len(own)} dimensions: a tensor has at most {MOST_DIMENSIONS}")
        self.dims = own + [0] * (MOST_DIMENSIONS - len(own))

    def getDims(self):
        return self.dims

    def getType(self):
        return self.type
