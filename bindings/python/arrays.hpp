// Converts between NumPy arrays and the tensors of include/weir.
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

// The names that NumPy has for the types of tensors, in the order of weir_type.
inline constexpr const char* kTypeNames[WEIR_TYPE_END] = {"int32", "uint32", "int16",   "uint16",
                                                          "int8",  "uint8",  "float64", "float32",
                                                          "int64", "uint64", "float16"};

// The arrays of a call's arguments, made dense, and views of them, valid as long as this object.
class LentArrays {
 public:
  // Accepts one array, or a list or tuple of arrays; converts other objects to arrays. TYPE_SYNTAX
  // for a dtype that tensors do not have.
  explicit LentArrays(const py::object& given);
  const std::vector<TensorView>& views() const noexcept { return views_; }

 private:
  void add(const py::handle& given);
  std::vector<py::array> arrays_;
  std::vector<TensorView> views_;
};

// Returns a read-only array over the tensor's memory, which `owner` keeps alive.
py::array make_array(const Tensor& tensor, const py::object& owner);

py::object to_dtype(weir_type type);            // None for WEIR_TYPE_END
py::object make_shape(const TensorInfo& info);  // None for open dimensions; None for an open rank

// Accepts any sequence of integers as a shape.
TensorShape shape_from(const py::handle& shape);

}  // namespace weir::bindings
