// weir.Pipeline and weir.Frame.
#pragma once
#include <pybind11/pybind11.h>

namespace weir::bindings {

void bind_pipeline(pybind11::module_& module);

}  // namespace weir::bindings
