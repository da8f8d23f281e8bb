// Raises Weir's errors as Python exceptions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "raised.hpp"

namespace weir::bindings {
namespace {

// Never released: destructors must not call an interpreter that is finalising.
struct Classes {
  py::object error, code;
};
Classes& classes() {
  static auto* const kept = new Classes;
  return *kept;
}

}  // namespace

void set_error(py::object error, py::object code) {
  classes() = {std::move(error), std::move(code)};
}

void raise(const Error& error, const py::object& cause) {
  const auto& [type, code] = classes();
  // A text may come from a file: invalid UTF-8 in it must not hide the error.
  const auto text = [](const std::string& part) {
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(part.data(), static_cast<Py_ssize_t>(part.size()), "replace"));
  };
  const py::object value =
      type(code(static_cast<int>(error.code)), text(error.what), text(error.offered),
           text(error.needed), text(error.difference), text(error.fix), text(error.message()));
  if (cause) PyException_SetCause(value.ptr(), py::object(cause).release().ptr());
  PyErr_SetObject(type.ptr(), value.ptr());
  throw py::error_already_set();
}

}  // namespace weir::bindings
