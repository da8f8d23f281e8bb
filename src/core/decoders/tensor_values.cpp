// Converts elements of any type to float32.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/tensor_values.hpp"

#include <cstdint>
#include <cstring>

#include "core/tensor/element_type.hpp"

namespace weir::decoders {
namespace {

constexpr size_t kMostElements = size_t{1} << 31;

template <class T>
void convert(const void* data, std::span<float> to) {
  const auto* from = static_cast<const std::byte*>(data);
  for (size_t i = 0; i < to.size(); ++i) {
    T value;
    std::memcpy(&value, from + i * sizeof value, sizeof value);
    to[i] = static_cast<float>(value);
  }
}

}  // namespace

size_t element_count(const weir_tensor_info& info) {
  size_t count = info.rank <= WEIR_RANK_LIMIT && info.type < WEIR_TYPE_END ? 1 : 0;
  for (uint32_t i = 0; count > 0 && i < info.rank; ++i) {
    const bool fits = info.shape[i] > 0 && size_t(info.shape[i]) <= kMostElements / count;
    count = fits ? count * size_t(info.shape[i]) : 0;
  }
  if (count > 0) return count;
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the decoder needs a tensor of a known size",
                 .offered = describe(info),
                 .needed = "extents above 0, at most 2147483648 elements"});
}

std::span<const float> TensorValues::read(const weir_tensor& tensor) {
  const size_t count = element_count(tensor.info);
  if (!tensor.data || tensor.bytes != count * element_bytes(tensor.info.type))
    throw Failure({.code = Code::FRAME_SIZE,
                   .what = "the frame does not have the size of its shape",
                   .offered = std::to_string(tensor.data ? tensor.bytes : 0) + " bytes",
                   .needed = describe(tensor.info)});
  const bool is_aligned = reinterpret_cast<uintptr_t>(tensor.data) % alignof(float) == 0;
  if (tensor.info.type == WEIR_FLOAT32 && is_aligned) return elements<const float>(tensor);
  converted_.resize(count);
  visit_type(static_cast<ElementType>(tensor.info.type),
             [&]<class T>(std::type_identity<T>) { convert<T>(tensor.data, converted_); });
  return converted_;
}

}  // namespace weir::decoders
