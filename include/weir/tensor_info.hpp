// Tensor types for programs: descriptions (type, shape, name) and views of memory as tensors.
// Shapes are outermost-first as in NumPy, -1 = open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "weir/module.hpp"

#include "weir/join.hpp"

namespace weir {

// The bits of an IEEE 754 binary16, for spans of WEIR_FLOAT16.
struct Float16 {
  uint16_t bits = 0;
};

// The weir_type of a C++ type: type_of<float> is WEIR_FLOAT32.
template <class T>
inline constexpr weir_type type_of = WEIR_TYPE_END;
template <>
inline constexpr weir_type type_of<int8_t> = WEIR_INT8;
template <>
inline constexpr weir_type type_of<int16_t> = WEIR_INT16;
template <>
inline constexpr weir_type type_of<int32_t> = WEIR_INT32;
template <>
inline constexpr weir_type type_of<int64_t> = WEIR_INT64;
template <>
inline constexpr weir_type type_of<uint8_t> = WEIR_UINT8;
template <>
inline constexpr weir_type type_of<uint16_t> = WEIR_UINT16;
template <>
inline constexpr weir_type type_of<uint32_t> = WEIR_UINT32;
template <>
inline constexpr weir_type type_of<uint64_t> = WEIR_UINT64;
template <>
inline constexpr weir_type type_of<Float16> = WEIR_FLOAT16;
template <>
inline constexpr weir_type type_of<float> = WEIR_FLOAT32;
template <>
inline constexpr weir_type type_of<double> = WEIR_FLOAT64;
template <class T>
concept TensorElement = (type_of<T> != WEIR_TYPE_END);

using TensorShape = std::vector<int64_t>;

// Returns "uint8", "float32", ...; "any type" for WEIR_TYPE_END.
inline std::string type_text(uint32_t type) {
  weir_tensor_info info{};
  info.type = type;
  const std::string text = describe(info);  // "uint8 1"
  return type < WEIR_TYPE_END ? text.substr(0, text.find(' ')) : "any type";
}

struct TensorInfo {
  std::string name;
  weir_type type = WEIR_TYPE_END;  // WEIR_TYPE_END: open
  bool rank_known = true;
  TensorShape shape;
  float scale = 0;  // real = scale * (value - zero_point); 0 = not quantised
  int32_t zero_point = 0;
  weir_layout layout = WEIR_LAYOUT_ANY;

  explicit TensorInfo(const weir_tensor_info& info)
      : name(info.name ? info.name : ""),
        type(info.type < WEIR_TYPE_END ? static_cast<weir_type>(info.type) : WEIR_TYPE_END),
        rank_known(info.rank <= WEIR_RANK_LIMIT),
        shape(info.shape, info.shape + (rank_known ? info.rank : 0)),
        scale(info.scale),
        zero_point(info.zero_point),
        layout(info.layout <= WEIR_LAYOUT_NONE ? static_cast<weir_layout>(info.layout)
                                               : WEIR_LAYOUT_ANY) {}

  // Returns the number of elements; -1 if an extent is open.
  int64_t elements() const noexcept {
    int64_t count = rank_known ? 1 : -1;
    for (const int64_t extent : shape) count = extent < 0 || count < 0 ? -1 : count * extent;
    return count;
  }
  // Returns "float32 (1, 224, ?) x".
  std::string to_string() const {
    std::string text = type_text(type) + (rank_known ? " (" : " any shape");
    text +=
        join(shape, ", ", [](int64_t extent) { return extent < 0 ? "?" : std::to_string(extent); });
    if (rank_known) text += shape.size() == 1 ? ",)" : ")";
    return name.empty() ? text : text + " " + name;
  }
};

// Elements that a program lends for the duration of a call. Without a shape they take the current
// shape of the model or stream.
class TensorView {
 public:
  // Views a vector, an array or a span.
  template <std::ranges::contiguous_range Elements,
            TensorElement Element = std::ranges::range_value_t<Elements>>
  TensorView(const Elements& elements, const TensorShape& shape = {})
      : TensorView(std::ranges::data(elements), std::ranges::size(elements) * sizeof(Element),
                   type_of<Element>, shape) {}
  // Views memory of any type, `bytes` long.
  TensorView(const void* data, uint64_t bytes, uint32_t type, const TensorShape& shape = {}) {
    tensor_.data = const_cast<void*>(data);
    tensor_.bytes = tensor_.capacity = bytes;
    tensor_.flags = WEIR_TENSOR_READONLY;
    tensor_.fence_fd = -1;
    tensor_.info.type = type;
    tensor_.info.batch_axis = WEIR_NO_BATCH_AXIS;
    // A shape with too many axes becomes one of unknown extents, which the callee rejects.
    const bool fits = shape.size() <= WEIR_RANK_LIMIT;
    tensor_.info.rank = shape.empty() ? WEIR_RANK_UNKNOWN : fits ? shape.size() : WEIR_RANK_LIMIT;
    for (uint32_t i = 0; i < WEIR_RANK_LIMIT && !shape.empty(); ++i)
      tensor_.info.shape[i] = !fits ? -1 : i < shape.size() ? shape[i] : 0;
  }
  const weir_tensor& c_tensor() const noexcept { return tensor_; }

 private:
  weir_tensor tensor_{};
};

// Writable elements that a call fills.
class WritableTensorView {
 public:
  template <std::ranges::contiguous_range Elements,
            TensorElement = std::ranges::range_value_t<Elements>>
  WritableTensorView(Elements&& elements) : view_(elements) {
    static_assert(
        !std::is_const_v<std::remove_reference_t<decltype(*std::ranges::data(elements))>>);
  }
  weir_tensor c_tensor() const noexcept {
    weir_tensor tensor = view_.c_tensor();
    tensor.flags = 0;
    return tensor;
  }

 private:
  TensorView view_;
};

// A borrowed tensor; the function that returns it documents its lifetime.
class Tensor {
 public:
  explicit Tensor(const weir_tensor& tensor) : tensor_(tensor) {}
  TensorInfo info() const { return TensorInfo(tensor_.info); }
  std::span<const std::byte> bytes() const noexcept {
    return {static_cast<const std::byte*>(tensor_.data), tensor_.bytes};
  }
  // Returns the elements; SPEC_MISMATCH if the tensor has another type.
  template <TensorElement T>
  Result<std::span<const T>> as() const {
    if (tensor_.info.type != type_of<T>)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the tensor has a different type",
                   .offered = info().to_string(),
                   .needed = type_text(type_of<T>),
                   .fix = "as<T>() with the type of info()"};
    return std::span<const T>(static_cast<const T*>(tensor_.data), tensor_.bytes / sizeof(T));
  }

 private:
  weir_tensor tensor_;
};

}  // namespace weir
