# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir.Pipeline: runs a pipeline from a program."""

from __future__ import annotations

import atexit
import json
import sys
import typing
import weakref

from . import _weir
from ._weir import Frame
from .error import Error, PipelineWarning

_pipelines: weakref.WeakSet[Pipeline] = weakref.WeakSet()
_SINKS = ("tensor_sink", "appsink")


class Pipeline(_weir.Pipeline):
    __doc__ = _weir.Pipeline.__doc__

    def __init__(self, text: str):
        super().__init__(text)
        self.text = text
        _pipelines.add(self)

    def frames(self, name: typing.Optional[str] = None, timeout: typing.Optional[float] = None) -> typing.Iterator[Frame]:
        """Iterates over the frames of a tensor_sink or appsink until its stream ends: for frame in pipeline.frames("out").

        name: the name of the sink. Optional if the pipeline has only one sink.
        timeout: seconds to wait for each frame. Raises TimeoutError if no frame arrives. None waits without limit.
        If the pipeline is stopped, the iteration starts it, and stops it at the end. An error of the pipeline raises weir.Error.
        """
        sink = self._only_sink() if name is None else name
        return self._frames(sink, timeout)

    def _frames(self, name: str, timeout: typing.Optional[float]) -> typing.Iterator[Frame]:
        if self.state == "stopped":
            with self:
                yield from self._frames(name, timeout)
            return
        while (frame := self.pull(name, timeout)) is not None:
            yield frame
        if not self.ended(name):
            raise TimeoutError(f"no frame came from {name} in {timeout} seconds")

    def _only_sink(self) -> str:
        sinks = [name for name, kind in self.elements().items() if kind in _SINKS]
        if len(sinks) == 1:
            return sinks[0]
        if not sinks:
            raise ValueError("the pipeline has no sink for frames: end it with tensor_sink name=out")
        raise ValueError(f"the pipeline has several sinks, so name one: pipeline.frames({sinks[0]!r}); "
                         f"they are {', '.join(map(repr, sinks))}")

    def stats(self, name: typing.Optional[str] = None) -> dict[str, typing.Any]:
        """Returns the property "stats" of the element `name` as a dict: frames received, dropped, ... and the element's own counters.

        After the pipeline has stopped, these are the counters at its last stop.
        Without a name, returns a dict with the stats of all elements that have this property, by element name.
        """
        if name is not None:
            stats: dict[str, typing.Any] = json.loads(self._get_stats(name))
            return stats
        found = {}
        for element in self.elements():
            try:
                found[element] = self.stats(element)
            except Error:  # it has no stats
                continue
        return found

    def __repr__(self) -> str:
        return f"<weir.Pipeline {'closed' if self.closed else self.state}: {self.text}>"

    def __enter__(self) -> Pipeline:
        try:
            self.start()
        except BaseException:
            self.__exit__(*sys.exc_info())
            raise
        return self

    def __exit__(self, kind: object, *_raised: object) -> None:
        if self.closed:
            return
        try:
            self.stop()
        except PipelineWarning:
            if kind is None:  # otherwise it would hide the exception of the block
                raise


@atexit.register
def _stop_all() -> None:
    """Streaming threads must not enter an interpreter that is finalising."""
    for pipeline in list(_pipelines):
        pipeline.close()
