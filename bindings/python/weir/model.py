# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir.Model and its outputs."""

from __future__ import annotations

import typing

from . import _weir

if typing.TYPE_CHECKING:
    import numpy.typing

    Array = numpy.typing.NDArray[typing.Any]

# An array, or what numpy.asarray makes one of.
Input = typing.Any
# Outputs, or None if the model drops the frame. A type checker does not insist on the check: few models drop frames.
MaybeOutputs = typing.Union["Outputs", typing.Any]


class Outputs(typing.List["Array"]):
    """The outputs of a model: a list of arrays that you can also index by name.

    outputs[0] and outputs["scores"] are the same array if "scores" is the name of the model's first output. `names` has all
    names in the order of the list. The arrays are read-only and can outlive the model.
    """

    def __init__(self, arrays: typing.Iterable[Array], names: typing.Sequence[str]):
        super().__init__(arrays)
        self.names = tuple(names)

    @typing.overload  # type: ignore[override]  # a list has no items by name
    def __getitem__(self, key: typing.Union[int, str]) -> Array: ...
    @typing.overload
    def __getitem__(self, key: slice) -> list[Array]: ...

    def __getitem__(self, key: typing.Union[int, slice, str]) -> typing.Union[Array, list[Array]]:
        if not isinstance(key, str):
            return super().__getitem__(key)
        if key in self.names:
            return super().__getitem__(self.names.index(key))
        raise KeyError(f"the model has no output {key!r}; its outputs are {', '.join(map(repr, self.names))}")

    def as_dict(self) -> dict[str, Array]:
        """Returns the outputs by name. If several outputs have the same name, returns the first."""
        return {name: self[name] for name in self.names}

    def __repr__(self) -> str:
        return "<weir.Outputs {}>".format(", ".join(
            f"{name or number}: {array.dtype} {array.shape}" for number, (name, array) in enumerate(zip(self.names, self))))


class Model(_weir.Model):
    __doc__ = _weir.Model.__doc__

    def __call__(self, *inputs: Input, **named: Input) -> MaybeOutputs:
        """Runs the model once: model(x), model(x, y), model([x, y]), model({"image": x}) or model(image=x).

        Returns Outputs, or None if the model drops the frame. See invoke().
        """
        if named:
            if inputs:
                raise TypeError("inputs are given either in their order or by name, not both")
            return self.invoke(named)
        return self.invoke(inputs[0] if len(inputs) == 1 else inputs)

    def invoke(self, inputs: Input) -> MaybeOutputs:
        """Runs the model on one array, on a list with an array for each input, or on a dict of arrays by the names of inputs.

        The dtype of an array must be that of the input. It is never converted silently. Returns Outputs, which is a list of
        read-only arrays, or None if the model drops the frame.
        """
        if isinstance(inputs, dict):
            inputs = self._in_order(inputs)
        arrays = super().invoke(inputs)
        return None if arrays is None else Outputs(arrays, self._output_names())

    def invoke_batch(self, frames: typing.Sequence[Input]) -> typing.Optional[list[Outputs]]:
        """Runs several frames at once. Each frame is as for invoke(). Returns Outputs for each frame, or None if the model drops them."""
        ordered = [self._in_order(frame) if isinstance(frame, dict) else frame for frame in frames]
        all_outputs = super().invoke_batch(ordered)
        if all_outputs is None:
            return None
        names = self._output_names()
        return [Outputs(arrays, names) for arrays in all_outputs]

    def _output_names(self) -> list[str]:
        return [info.name for info in self.outputs]

    def _in_order(self, named: dict[str, Input]) -> list[Input]:
        names = [info.name for info in self.inputs]
        unknown = [name for name in named if name not in names]
        missing = [name for name in names if name not in named]
        if unknown or missing:
            wrong = f"it has no input {unknown[0]!r}" if unknown else f"the input {missing[0]!r} is missing"
            raise KeyError(f"{wrong}; the model's inputs are {', '.join(map(repr, names))}")
        return [named[name] for name in names]

    def __repr__(self) -> str:
        if self.closed:
            return "<weir.Model closed>"
        texts = [", ".join(map(str, infos)) or "none" for infos in (self.inputs, self.outputs)]
        return f"<weir.Model {self.engine}: {texts[0]} -> {texts[1]}>"

    def __enter__(self) -> Model:
        return self
