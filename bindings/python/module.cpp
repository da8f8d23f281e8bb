// The extension module weir._weir; the package weir wraps it in Python.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <pybind11/pybind11.h>

#include "exceptions.hpp"
#include "frame_binding.hpp"
#include "model_binding.hpp"
#include "pipeline_binding.hpp"

PYBIND11_MODULE(_weir, module) {
  module.attr("VERSION") = WEIR_PYTHON_VERSION;
  module.def("set_error", &weir::bindings::set_error);
  weir::bindings::bind_model(module);
  weir::bindings::bind_frame(module);
  weir::bindings::bind_pipeline(module);
}
