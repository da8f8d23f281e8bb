# SPDX-License-Identifier: LGPL-2.1-or-later
"""The class that scripts of NNStreamer's tensor_filter and tensor_converter import."""

from weir import TensorShape

__all__ = ["TensorShape"]
