"""The filter my-filter: y = 255 - x, on one tensor of uint8 of any shape."""

import numpy
from nnstreamer_python import TensorShape


class CustomFilter:
    """Weir makes one object of this class for each element."""

    def __init__(self, *words):
        """The words of custom="..."."""
        self.words = words

    def setInputDim(self, input_dims):
        """Gets the stream's tensors; says the outputs'. Dimensions are innermost first."""
        if len(input_dims) != 1 or input_dims[0].getType() != numpy.uint8:
            raise ValueError("my-filter takes one tensor of uint8")
        return [TensorShape(input_dims[0].getDims(), numpy.uint8)]

    def invoke(self, input_array):
        """A list of one-dimensional arrays in, a list of arrays of the said types and sizes out."""
        return [255 - input_array[0]]
