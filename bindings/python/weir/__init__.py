# SPDX-License-Identifier: LGPL-2.1-or-later
"""Weir: neural networks as filters in GStreamer pipelines, and single models, with NumPy arrays.

weir.Model runs one model in any engine, weir.Pipeline plays a pipeline, and weir.TensorShape is for scripts that a
pipeline runs. weir.results reads streams of results. Failures raise weir.Error.
"""

import atexit
import enum
import weakref

from . import _weir, results
from ._weir import Frame, Model, TensorInfo
from .error import Error
from .tensor_shape import TensorShape

__all__ = ["Code", "Error", "Frame", "Model", "Pipeline", "TensorInfo", "TensorShape", "results"]

__version__ = _weir.VERSION

Code = enum.IntEnum("Code", _weir.CODES, module=__name__)
Code.__doc__ = "The codes of weir.Error. docs/errors has a page for each."
Error.__module__ = __name__  # as users write it, in tracebacks
_weir.set_error(Error, Code)

_pipelines = weakref.WeakSet()


class Pipeline(_weir.Pipeline):
    __doc__ = _weir.Pipeline.__doc__

    def __init__(self, text):
        super().__init__(text)
        self.text = text
        _pipelines.add(self)

    def __repr__(self):
        return f"<weir.Pipeline {'closed' if self.closed else self.state}: {self.text}>"

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_raised):
        self.stop()


@atexit.register
def _stop_all():
    """Streaming threads must not enter an interpreter that is finalising."""
    for pipeline in list(_pipelines):
        pipeline.close()
