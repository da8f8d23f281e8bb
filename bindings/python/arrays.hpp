// NumPy arrays and the tensors of include/weir.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <vector>

#include "weir/tensor_info.hpp"

namespace weir::bindings {

namespace py = pybind11;

// The arrays that a call lends, dense, and views of them; they live as long as the object.
class LentArrays {
 public:
  // One array, or a list or tuple of arrays; what is no array becomes one. TYPE_SYNTAX for a dtype
  // that no tensor has.
  explicit LentArrays(const py::object& given);
  const std::vector<TensorView>& views() const noexcept { return views_; }

 private:
  void add(const py::handle& given);
  std::vector<py::array> arrays_;
  std::vector<TensorView> views_;
};

// A read-only array over the tensor's memory, which `owner` keeps.
py::array array_of(const Tensor& tensor, const py::object& owner);

py::object dtype_of(weir_type type);          // None for WEIR_TYPE_END
py::object shape_of(const TensorInfo& info);  // None for what is open; None when the rank is

// A shape of Python: any sequence of whole numbers.
TensorShape shape_from(const py::handle& shape);

}  // namespace weir::bindings
