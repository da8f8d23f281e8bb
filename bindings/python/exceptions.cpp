// SPDX-License-Identifier: LGPL-2.1-or-later
#include "exceptions.hpp"

#include <algorithm>
#include <iterator>

#include "arrays.hpp"

namespace weir::bindings {
namespace {

// Never released: destructors must not call an interpreter that is finalising.
struct Classes {
  py::object error, code, spelling, warn;
};
Classes& classes() {
  static auto* const kept = new Classes;
  return *kept;
}

// A text may come from a file or a peer: invalid UTF-8 in it must not hide the error, and a
// terminal shows its control characters.
py::object text(const std::string& part) {
  const std::string shown = printable_text(part);
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(shown.data(), static_cast<Py_ssize_t>(shown.size()), "replace"));
}

// A weir.Error with the parts of `error`.
py::object python_error(const Error& error) {
  const auto& known = classes();
  return known.error(known.code(static_cast<int>(error.code)), text(error.what),
                     text(error.offered), text(error.needed), text(error.difference),
                     text(error.fix), text(error.message()));
}

bool is_type(const std::string& name) {
  return std::find(std::begin(kTypeNames), std::end(kTypeNames), name) != std::end(kTypeNames);
}

}  // namespace

void set_error(py::object error, py::object code, py::object spelling, py::object warn) {
  classes() = {std::move(error), std::move(code), std::move(spelling), std::move(warn)};
}

void raise(const Error& error, const py::object& cause) {
  const py::object value = python_error(error);
  if (cause) PyException_SetCause(value.ptr(), py::object(cause).release().ptr());
  PyErr_SetObject(classes().error.ptr(), value.ptr());
  throw py::error_already_set();
}

void warn(const Error& warning) {
  classes().warn(python_error(warning));
}

void raise_of_model(Error error) {
  const auto spelled = [](const std::string& part) {
    return py::cast<std::string>(classes().spelling(text(part)));
  };
  if (error.fix.empty() && is_type(error.offered) && is_type(error.needed))
    error.fix = "array.astype(numpy." + error.needed + ")";
  error.offered = spelled(error.offered);
  error.fix = spelled(error.fix);
  raise(error);
}

}  // namespace weir::bindings
