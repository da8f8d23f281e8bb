"""The filter my-filter: y = 255 - x, for one uint8 tensor of any shape."""

import numpy
from nnstreamer_python import TensorShape


class CustomFilter:
    """Weir creates one object of this class per element."""

    def __init__(self, *words):
        """Receives the words of custom="..."."""
        self.words = words

    def setInputDim(self, input_dims):
        """Receives the stream's tensors and returns the outputs'. Dimensions are innermost first."""
        if len(input_dims) != 1 or input_dims[0].getType() != numpy.uint8:
            raise ValueError("my-filter takes one tensor of uint8")
        return [TensorShape(input_dims[0].getDims(), numpy.uint8)]

    def invoke(self, input_array):
        """Receives one-dimensional arrays and returns arrays of the declared types and sizes."""
        return [255 - input_array[0]]
