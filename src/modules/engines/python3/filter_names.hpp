// The half of the engine that is written in Python: what a script says of its tensors, and words
// for what it gave.
#pragma once

namespace weir::engine {

// Of tensors here: (type by its number in abi.h, dimensions innermost first).
inline constexpr char kFilterNames[] = R"py(
import gc, sys
import numpy
from weir_scripts import TYPES, TensorShape, tensor_of

DTYPES = {number: dtype for dtype, number in TYPES.items()}
MOST_TENSORS = 256

def has(script, name):
    return callable(getattr(script, name, None))

# Is the script told its inputs (setInputDim), or does it say them?
def is_told(script):
    if not has(script, "invoke"):
        raise AttributeError("the class CustomFilter has no method invoke(self, input_array)")
    if has(script, "setInputDim"):
        return True
    if has(script, "getInputDim") and has(script, "getOutputDim"):
        return False
    raise AttributeError("the class CustomFilter has neither setInputDim(self, input_dims) nor both "
                         "getInputDim(self) and getOutputDim(self)")

def tensors_of(method, shapes):
    if not isinstance(shapes, (list, tuple)):
        raise TypeError(f"{method} returns a list of TensorShape, not {type(shapes).__name__}")
    if not 1 <= len(shapes) <= MOST_TENSORS:
        raise ValueError(f"{method} returned {len(shapes)} TensorShapes: 1 to {MOST_TENSORS} can be")
    for i, shape in enumerate(shapes):
        if not (has(shape, "getDims") and has(shape, "getType")):
            raise TypeError(f"{method}: entry {i} of its list is no TensorShape but "
                            f"{type(shape).__name__}")
    return tuple(tensor_of(shape) for shape in shapes)

def told_by(script, method):
    return tensors_of(method, getattr(script, method)())

def tell(script, *tensors):
    shapes = [TensorShape(list(dims), DTYPES[number]) for number, dims in tensors]
    return tensors_of("setInputDim", script.setInputDim(shapes))

def words(tensor):
    number, dims = tensor
    return f"{DTYPES[number]} {':'.join(map(str, dims))}"

# What invoke returned, dense; or what is wrong with it.
def checked(made, *tensors):
    if not isinstance(made, (list, tuple)):
        raise TypeError(f"invoke returns a list of NumPy arrays, not {type(made).__name__}")
    if len(made) != len(tensors):
        raise ValueError(f"invoke returned {len(made)} arrays, needed are {len(tensors)}: "
                         f"{', '.join(map(words, tensors))}")
    for i, (array, tensor) in enumerate(zip(made, tensors)):
        number, dims = tensor
        if not isinstance(array, numpy.ndarray):
            raise TypeError(f"output {i} is no NumPy array but {type(array).__name__}, needed is "
                            f"{words(tensor)}")
        if array.dtype != DTYPES[number]:
            raise TypeError(f"output {i} is an array of {array.dtype}, needed is {words(tensor)}: "
                            f"array.astype(numpy.{DTYPES[number]})")
        needed = DTYPES[number].itemsize
        for dim in dims:
            needed *= dim
        if array.nbytes != needed:
            raise ValueError(f"output {i} has {array.nbytes} bytes, shape {array.shape}, needed are "
                             f"{needed}: {words(tensor)}")
    return tuple(numpy.ascontiguousarray(array, DTYPES[number])
                 for array, (number, _) in zip(made, tensors))

def fresh():
    return [numpy.empty(1)]

# References to an array that owns its memory, those of the call among them; 0 for any other.
def references(array):
    return sys.getrefcount(array) if array.base is None and array.flags.owndata else 0

# The same of the list that it came in.
def references_of_list(made):
    return sys.getrefcount(made)

# Whoever finds it after all can read it and no more.
def lock(array):
    array.flags.writeable = False

def collect():
    gc.collect()
)py";

}  // namespace weir::engine
