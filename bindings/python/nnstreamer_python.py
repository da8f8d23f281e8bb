# SPDX-License-Identifier: LGPL-2.1-or-later
"""Provides the class that NNStreamer's scripts for tensor_filter and tensor_converter import."""

from weir import TensorShape

__all__ = ["TensorShape"]
