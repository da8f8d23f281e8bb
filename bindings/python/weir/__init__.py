# SPDX-License-Identifier: LGPL-2.1-or-later
"""Weir: neural networks as filters in GStreamer pipelines, and single models, with NumPy arrays.

    for frame in weir.Pipeline("... ! tensor_decoder mode=detection ! tensor_sink").frames():
        for found in frame.results:
            print(found.label, found.score, found.box)

    scores, = weir.Model("net.onnx")(image)

weir.Pipeline plays a pipeline, weir.Model runs one model in any engine, weir.results reads tensors of results, and
weir.TensorShape is for scripts that a pipeline runs. Failures raise weir.Error.
"""

from . import _weir, results
from ._weir import Frame, SourceMap, TensorInfo
from .codes import Code
from .error import Error, python_spelling
from .model import Model, Outputs
from .pipeline import Pipeline
from .tensor_shape import TensorShape

__all__ = ["Code", "Error", "Frame", "Model", "Outputs", "Pipeline", "SourceMap", "TensorInfo", "TensorShape", "results"]
__version__ = _weir.VERSION

for public in (Code, Error, Model, Outputs, Pipeline):
    public.__module__ = __name__  # as users write it, in tracebacks and help()
del public
_weir.set_error(Error, Code, python_spelling)
