// SPDX-License-Identifier: LGPL-2.1-or-later
#include "arrays.hpp"

#include "exceptions.hpp"

namespace weir::bindings {
namespace {

weir_type type_of_array(const py::array& array) {
  const py::dtype dtype = array.dtype();
  const char order = dtype.byteorder();
  const auto size = dtype.itemsize();
  if (order == '=' || order == '|')
    for (int type = 0; type < WEIR_TYPE_END; ++type) {
      const char kind = kTypeNames[type][0];
      if (dtype.kind() == kind && size == static_cast<py::ssize_t>(element_bytes(type)))
        return static_cast<weir_type>(type);
    }
  raise({.code = Code::TYPE_SYNTAX,
         .what = "no tensor has elements of this type",
         .offered = py::str(static_cast<py::object>(dtype)),
         .needed = "one of int8 to int64, uint8 to uint64, float16, float32, float64",
         .fix = "array.astype(numpy.float32)"});
}

}  // namespace

LentArrays::LentArrays(const py::object& given) {
  if (py::isinstance<py::list>(given) || py::isinstance<py::tuple>(given)) {
    for (const auto part : py::reinterpret_borrow<py::sequence>(given)) add(part);
  } else {
    add(given);
  }
}

void LentArrays::add(const py::handle& given) {
  auto array = py::array::ensure(given, py::array::c_style);
  if (!array) throw py::error_already_set();
  if (array.ndim() > WEIR_RANK_LIMIT)
    raise({.code = Code::LIMIT_EXCEEDED,
           .what = "an array has too many axes",
           .offered = std::to_string(array.ndim()) + " axes",
           .needed = "at most " + std::to_string(WEIR_RANK_LIMIT),
           .fix = "array.reshape(array.shape[:15] + (-1,))"});
  const weir_type type = type_of_array(array);
  const TensorShape shape(array.shape(), array.shape() + array.ndim());
  views_.emplace_back(array.data(), static_cast<uint64_t>(array.nbytes()), type, shape);
  arrays_.push_back(std::move(array));
}

py::array make_array(const Tensor& tensor, const py::object& owner) {
  const TensorInfo info = tensor.info();
  py::array array(py::dtype(kTypeNames[info.type]), info.shape, tensor.bytes().data(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

py::object to_dtype(weir_type type) {
  if (type == WEIR_TYPE_END) return py::none();
  return py::dtype(kTypeNames[type]);
}

py::object make_shape(const TensorInfo& info) {
  if (!info.rank_known) return py::none();
  py::tuple shape(info.shape.size());
  for (size_t i = 0; i < info.shape.size(); ++i)
    shape[i] = info.shape[i] < 0 ? py::object(py::none()) : py::object(py::int_(info.shape[i]));
  return shape;
}

TensorShape shape_from(const py::handle& shape) {
  TensorShape out;
  for (const auto extent : py::cast<py::sequence>(shape)) out.push_back(py::cast<int64_t>(extent));
  return out;
}

}  // namespace weir::bindings
