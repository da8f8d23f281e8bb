// weir.Model and weir.TensorInfo.
#pragma once
#include <pybind11/pybind11.h>

namespace weir::bindings {

void bind_model(pybind11::module_& module);

}  // namespace weir::bindings
