// Registers weir.Frame and weir.SourceMap.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <pybind11/pybind11.h>

namespace weir::bindings {

void bind_frame(pybind11::module_& module);

}  // namespace weir::bindings
