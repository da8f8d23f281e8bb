# SPDX-License-Identifier: LGPL-2.1-or-later
"""A tensor's dimensions and type, as declared by scripts of tensor_filter and tensor_converter."""

from __future__ import annotations

import typing

import numpy

MOST_DIMENSIONS = 16


class TensorShape:
    """Dimensions innermost first, with zeros up to 16, and the type of the elements.

    `dims` is a copy: changes to the given list do not affect it.
    """

    # The name of the argument `type` comes from NNStreamer.
    def __init__(self, dims: typing.Optional[list[int]] = None, type: typing.Any = numpy.uint8) -> None:
        self.setDims([] if dims is None else dims)
        self.type = numpy.dtype(type)

    def setDims(self, dims: list[int]) -> None:
        if not isinstance(dims, list):
            raise TypeError(f"the dimensions of a TensorShape are a list, not {type(dims).__name__}")
        own = list.copy(dims)
        if len(own) > MOST_DIMENSIONS:
            raise ValueError(f"{len(own)} dimensions: a tensor has at most {MOST_DIMENSIONS}")
        self.dims = own + [0] * (MOST_DIMENSIONS - len(own))

    def getDims(self) -> list[int]:
        return self.dims

    def getType(self) -> numpy.dtype[typing.Any]:
        return self.type
