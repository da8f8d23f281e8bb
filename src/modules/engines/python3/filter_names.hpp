// The part of the engine that is written in Python: reads the tensors that a script declares and
// describes errors in its output.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace weir::engine {

// A tensor here is (the number of its type in abi.h, dimensions innermost first).
inline constexpr char kFilterNames[] = R"py(
import gc, sys
import numpy
from weir_scripts import DTYPES, TensorShape, is_a, tensor_of

MOST_TENSORS = 256

def has(script, name):
    return callable(getattr(script, name, None))

# Does the script compute its outputs from given inputs (setInputDim), or declare both?
def takes_input_shapes(script):
    if not has(script, "invoke"):
        raise AttributeError("the class CustomFilter has no method invoke(self, input_array)")
    if has(script, "setInputDim"):
        return True
    if has(script, "getInputDim") and has(script, "getOutputDim"):
        return False
    raise AttributeError("the class CustomFilter has neither setInputDim(self, input_dims) nor both "
                         "getInputDim(self) and getOutputDim(self)")

def tensors_of(method, shapes):
    if not is_a((list, tuple), shapes):
        raise TypeError(f"{method} must return a list of TensorShape, not {type(shapes).__name__}")
    shapes = list(shapes)  # read once: a subclass may have another length the next time
    if not 1 <= len(shapes) <= MOST_TENSORS:
        raise ValueError(f"{method} returned {len(shapes)} TensorShapes: 1 to {MOST_TENSORS} can be")
    for i, shape in enumerate(shapes):
        if not (has(shape, "getDims") and has(shape, "getType")):
            raise TypeError(f"{method}: entry {i} of its list is not a TensorShape but "
                            f"{type(shape).__name__}")
    return tuple(tensor_of(shape) for shape in shapes)

def declared_by(script, method):
    return tensors_of(method, getattr(script, method)())

def set_inputs(script, *tensors):
    shapes = [TensorShape(list(dims), DTYPES[number]) for number, dims in tensors]
    return tensors_of("setInputDim", script.setInputDim(shapes))

def describe(tensor):
    number, dims = tensor
    return f"{DTYPES[number]} {':'.join(map(str, dims))}"

# One output, dense; or what is wrong with it.
def dense(i, array, tensor):
    number, dims = tensor
    if not is_a(numpy.ndarray, array):
        raise TypeError(f"output {i} is not a NumPy array but {type(array).__name__}, needed is "
                        f"{describe(tensor)}")
    array = numpy.asarray(array)  # a subclass may report another type or size than its memory has
    if array.dtype != DTYPES[number]:
        raise TypeError(f"output {i} is an array of {array.dtype}, needed is {describe(tensor)}: "
                        f"array.astype(numpy.{DTYPES[number]})")
    needed = DTYPES[number].itemsize
    for dim in dims:
        needed *= dim
    if array.nbytes != needed:
        raise ValueError(f"output {i} has {array.nbytes} bytes, shape {array.shape}, needed are "
                         f"{needed}: {describe(tensor)}")
    return numpy.ascontiguousarray(array, DTYPES[number])

# What invoke returned, as a tuple of dense arrays.
def checked(made, *tensors):
    if not is_a((list, tuple), made):
        raise TypeError(f"invoke must return a list of NumPy arrays, not {type(made).__name__}")
    made = list(made)
    if len(made) != len(tensors):
        raise ValueError(f"invoke returned {len(made)} arrays, needed are {len(tensors)}: "
                         f"{', '.join(map(describe, tensors))}")
    return tuple(dense(i, *pair) for i, pair in enumerate(zip(made, tensors)))

def fresh():
    return [numpy.empty(1)]

# References to an array that owns its memory, those of the call among them; 0 for any other. Of a
# subclass nothing is known: it may report to own what it does not.
def references(array):
    owns = type(array) is numpy.ndarray and array.base is None and array.flags.owndata
    return sys.getrefcount(array) if owns else 0

# The same of the list that it came in.
def references_of_list(made):
    return sys.getrefcount(made)

# Code that reaches it anyway can only read it.
def lock(array):
    array.flags.writeable = False

def collect():
    gc.collect()
)py";

}  // namespace weir::engine
