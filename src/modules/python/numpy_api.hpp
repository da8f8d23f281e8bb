// Numpy: makes arrays over our memory through the function table that NumPy exports to extensions.
// Its indices are stable since NumPy 1.7; building needs no NumPy header.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

#include "interpreter.hpp"
#include "weir/abi.h"

namespace weir::python {

class Numpy {
 public:
  // Call under Locked. ENGINE_NOT_INSTALLED for a NumPy with an unknown table.
  static Result<Numpy> open(const PythonApi& api);

  // Returns a read-only one-dimensional array of `count` elements of `type`, a weir_type, at
  // `data`. The array and all its views keep `owner` alive. Null, with Python's exception set, on
  // failure.
  Object view(uint32_t type, const void* data, int64_t count, const Object& owner) const;
  PyObject* array_type() const noexcept { return array_type_; }

 private:
  using Descr = PyObject;
  PyObject* array_type_ = nullptr;  // these exist until the process exits
  Descr* (*descr_from_type_)(int) = nullptr;
  PyObject* (*new_from_descr_)(PyObject*, Descr*, int, const intptr_t*, const intptr_t*, void*, int,
                               PyObject*) = nullptr;
  int (*set_base_)(PyObject*, PyObject*) = nullptr;
};

}  // namespace weir::python
