# SPDX-License-Identifier: LGPL-2.1-or-later
"""Weir: neural networks as filters in GStreamer pipelines, and single models, with NumPy arrays.

    for frame in weir.Pipeline("... ! tensor_decoder mode=detection ! tensor_sink").frames():
        for found in frame.results:
            print(found.label, found.score, found.box)

    scores, = weir.Model("net.onnx")(image)

weir.Pipeline runs a pipeline. weir.Model runs one model with any engine. weir.results reads result tensors. weir.TensorShape is
for scripts that a pipeline runs. Functions that fail raise weir.Error.
"""

import pathlib
import sys

from . import bundle as _bundle


def _why_not_loaded(missing: ImportError) -> str:
    """The extension module is for one version of Python, and needs Weir's libraries."""
    built = [path.name for path in pathlib.Path(__file__).parent.glob("_weir.*.so")]
    here = f"{sys.executable}, which is Python {sys.version_info.major}.{sys.version_info.minor}"
    if not built:
        return f"the package weir has no extension module in {pathlib.Path(__file__).parent}: make install, or apt-get install python3-weir, brings it"
    if sys.implementation.cache_tag.replace("cpython-", ".cpython-") not in built[0]:
        return f"weir was built for another Python: it has {built[0]}, and this is {here}; /usr/bin/python3 is Debian's"
    return f"weir cannot be loaded by {here}: {missing.msg}"


def _how_to_install_numpy() -> str:
    """Debian's package is for Debian's interpreter alone, not for one of pyenv or in a virtual environment."""
    if sys.prefix == "/usr":
        return ", which weir needs: apt-get install python3-numpy"
    return (f" in {sys.executable}, and weir needs it: {sys.executable} -m pip install numpy; "
            "apt-get install python3-numpy installs it only for /usr/bin/python3")


_bundle.use(pathlib.Path(__file__).parent / "bundle")
try:
    from . import _weir, results
except ImportError as missing:
    if missing.name == "numpy":
        missing.msg += _how_to_install_numpy()
    elif "_weir" in str(missing):
        missing.msg = _why_not_loaded(missing)
    raise
from ._weir import Frame, SourceMap, TensorInfo
from .codes import Code
from .error import Error, PipelineWarning, python_spelling, warn
from .model import Model, Outputs
from .pipeline import Pipeline
from .tensor_shape import TensorShape

__all__ = ["Code", "Error", "Frame", "Model", "Outputs", "Pipeline", "PipelineWarning", "SourceMap", "TensorInfo", "TensorShape", "results"]
__version__ = _weir.VERSION

for public in (Code, Error, Model, Outputs, Pipeline, PipelineWarning):
    public.__module__ = __name__  # as users write it, in tracebacks and help()
del public
_weir.set_error(Error, Code, python_spelling, warn)
