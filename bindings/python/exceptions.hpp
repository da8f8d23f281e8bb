// Converts errors of Weir to Python exceptions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <pybind11/pybind11.h>

#include <utility>

#include "weir/result.hpp"

namespace weir::bindings {

namespace py = pybind11;

// Sets the class weir.Error, the names of its codes, the function that spells parts of a model's
// errors as Python does, and the one that issues a warning; the package calls it once.
void set_error(py::object error, py::object code, py::object spelling, py::object warn);

// Throws the error as a weir.Error, whose __cause__ is the exception `cause` unless that is null.
// Call with the GIL held.
[[noreturn]] void raise(const Error& error, const py::object& cause = {});
// The same for an error of a model: its properties are spelled as arguments of weir.Model.
[[noreturn]] void raise_of_model(Error error);

// Issues a weir.PipelineWarning. Throws if the program's filter makes an exception of it. Call with
// the GIL held.
void warn(const Error& warning);

template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  return *std::move(result);
}
template <class T>
T value_of_model(Result<T> result) {
  if (!result) raise_of_model(result.error());
  return *std::move(result);
}

// Runs `body` without the GIL: for calls that block or join threads that need the GIL.
template <class Body>
auto unlocked(Body&& body) {
  const py::gil_scoped_release released;
  return body();
}

}  // namespace weir::bindings
