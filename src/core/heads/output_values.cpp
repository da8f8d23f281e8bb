// Converts the outputs of a frame to float32 on first use.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/output_values.hpp"

#include <cstdint>
#include <cstring>
#include <string>

#include "core/tensor/element_type.hpp"
#include "core/transform/float16_bits.hpp"

namespace weir::heads {
namespace {

constexpr size_t kMostElements = size_t{1} << 31;

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

template <class T>
void convert(const void* data, float scale, float zero_point, std::span<float> to) {
  const auto* from = static_cast<const std::byte*>(data);
  for (size_t i = 0; i < to.size(); ++i) {
    T value;
    std::memcpy(&value, from + i * sizeof value, sizeof value);
    if constexpr (std::is_same_v<T, float16>)
      to[i] = scale * (transform::widen(value) - zero_point);
    else
      to[i] = scale * (static_cast<float>(value) - zero_point);
  }
}

}  // namespace

void OutputValues::begin(std::span<const weir_tensor> tensors) {
  tensors_ = tensors;
  converted_.resize(tensors.size());
  known_.assign(tensors.size(), {});
}

std::span<const float> OutputValues::read(size_t index) {
  return read(index, true);
}
std::span<const float> OutputValues::read_raw(size_t index) {
  return read(index, false);
}

std::span<const float> OutputValues::read(size_t index, bool dequantise) {
  if (index >= tensors_.size())
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the frame has fewer tensors than the model has outputs",
                   .offered = std::to_string(tensors_.size()) + " tensors",
                   .needed = "at least " + std::to_string(index + 1)});
  if (!known_[index].empty()) return known_[index];
  const weir_tensor& tensor = tensors_[index];
  const size_t count = element_count(tensor.info);
  if (!tensor.data || tensor.bytes != count * element_bytes(tensor.info.type))
    throw Failure({.code = Code::FRAME_SIZE,
                   .what = "the frame has another size than its shape says",
                   .offered = std::to_string(tensor.data ? tensor.bytes : 0) + " bytes",
                   .needed = describe(tensor.info)});
  const bool is_aligned = reinterpret_cast<uintptr_t>(tensor.data) % alignof(float) == 0;
  const bool is_quantised = dequantise && tensor.info.scale != 0;
  if (tensor.info.type == WEIR_FLOAT32 && is_aligned && !is_quantised)
    return known_[index] = elements<const float>(tensor);
  converted_[index].resize(count);
  visit_type(static_cast<ElementType>(tensor.info.type), [&]<class T>(std::type_identity<T>) {
    convert<T>(tensor.data, is_quantised ? tensor.info.scale : 1.0f,
               is_quantised ? static_cast<float>(tensor.info.zero_point) : 0.0f, converted_[index]);
  });
  return known_[index] = converted_[index];
}

}  // namespace weir::heads
