// Arrays over memory of ours, through the table of functions that NumPy gives to extensions. Its
// places have not moved since NumPy 1.7; no header of NumPy is wanted to build.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

#include "interpreter.hpp"
#include "weir/abi.h"

namespace weir::python {

class Numpy {
 public:
  // Under Locked. ENGINE_NOT_INSTALLED for a NumPy whose table is not known.
  static Result<Numpy> open(const PythonApi& api);

  // A read-only array of one dimension over `count` elements of `type`, a weir_type, at `data`; it
  // and every view of it keep `owner` alive. Null with Python's exception set.
  Object view(uint32_t type, const void* data, int64_t count, const Object& owner) const;
  PyObject* array_type() const noexcept { return array_type_; }

 private:
  using Descr = PyObject;
  PyObject* array_type_ = nullptr;  // these live until the process ends
  Descr* (*descr_from_type_)(int) = nullptr;
  PyObject* (*new_from_descr_)(PyObject*, Descr*, int, const intptr_t*, const intptr_t*, void*, int,
                               PyObject*) = nullptr;
  int (*set_base_)(PyObject*, PyObject*) = nullptr;
};

}  // namespace weir::python
