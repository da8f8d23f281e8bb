"""A tensor's dimensions and type, as scripts of tensor_filter and tensor_converter say them."""

import numpy

MOST_DIMENSIONS = 16


class TensorShape:
    """Dimensions innermost first, with zeros up to 16, and the type of the elements."""

    def __init__(self, dims, dtype=numpy.uint8):
        self.setDims(dims)
        self.type = numpy.dtype(dtype)

    def setDims(self, dims):
        if not isinstance(dims, list):
            raise TypeError(f"the dimensions of a TensorShape are a list, not {type(dims).__name__}")
        if len(dims) > MOST_DIMENSIONS:
            raise ValueError(f"{len(dims)} dimensions: a tensor has at most {MOST_DIMENSIONS}")
        dims.extend([0] * (MOST_DIMENSIONS - len(dims)))
        self.dims = dims

    def getDims(self):
        return self.dims

    def getType(self):
        return self.type
