// Errors of Weir as exceptions of Python.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <pybind11/pybind11.h>

#include <utility>

#include "weir/result.hpp"

namespace weir::bindings {

namespace py = pybind11;

// The class weir.Error and the names of its codes; told by the package, once.
void set_error(py::object error, py::object code);

// Throws it as a weir.Error. Under Python's lock.
[[noreturn]] void raise(const Error& error);

template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  return *std::move(result);
}
inline void check(const Status& status) {
  if (!status) raise(status.error());
}

// Calls without Python's lock: what blocks, or ends threads that want it.
template <class Body>
auto unlocked(Body&& body) {
  const py::gil_scoped_release released;
  return body();
}

}  // namespace weir::bindings
