// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/output_values.hpp"

#include <cstdint>
#include <cstring>
#include <string>

#include "core/tensor/element_type.hpp"
#include "core/transform/float16_bits.hpp"

namespace weir::heads {
namespace {

constexpr size_t kMaxElements = size_t{1} << 31;

template <class T>
float real_from(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  if constexpr (std::is_same_v<T, float16>)
    return transform::widen(value);
  else
    return static_cast<float>(value);
}

template <class T>
void convert(const void* data, std::span<float> to) {
  const auto* from = static_cast<const std::byte*>(data);
  for (size_t i = 0; i < to.size(); ++i) to[i] = real_from<T>(from + i * sizeof(T));
}
template <class T>
void dequantise_values(const weir_tensor& tensor, std::span<float> to) {
  const float scale = tensor.info.scale, zero_point = static_cast<float>(tensor.info.zero_point);
  const auto* from = static_cast<const std::byte*>(tensor.data);
  for (size_t i = 0; i < to.size(); ++i)
    to[i] = scale * (real_from<T>(from + i * sizeof(T)) - zero_point);
}

}  // namespace

size_t element_count(const weir_tensor_info& info) {
  size_t count = info.rank <= WEIR_RANK_LIMIT && info.type < WEIR_TYPE_END ? 1 : 0;
  for (uint32_t i = 0; count > 0 && i < info.rank; ++i) {
    const bool fits = info.shape[i] > 0 && size_t(info.shape[i]) <= kMaxElements / count;
    count = fits ? count * size_t(info.shape[i]) : 0;
  }
  if (count > 0) return count;
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the decoder needs a tensor of a known size",
                 .offered = describe(info),
                 .needed = "extents above 0, at most 2147483648 elements"});
}

std::span<const float> read_values(const weir_tensor& tensor, bool dequantise,
                                   std::vector<float>* converted) {
  const size_t count = element_count(tensor.info);
  if (!tensor.data || tensor.bytes != count * element_bytes(tensor.info.type))
    throw Failure({.code = Code::FRAME_SIZE,
                   .what = "the frame does not have the size of its shape",
                   .offered = std::to_string(tensor.data ? tensor.bytes : 0) + " bytes",
                   .needed = describe(tensor.info)});
  const bool is_aligned = reinterpret_cast<uintptr_t>(tensor.data) % alignof(float) == 0;
  const bool is_quantised = dequantise && tensor.info.scale != 0;
  if (tensor.info.type == WEIR_FLOAT32 && is_aligned && !is_quantised)
    return elements<const float>(tensor);
  converted->resize(count);
  visit_type(static_cast<ElementType>(tensor.info.type), [&]<class T>(std::type_identity<T>) {
    if (is_quantised)
      dequantise_values<T>(tensor, *converted);
    else
      convert<T>(tensor.data, *converted);
  });
  return *converted;
}

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
  return known_[index] = read_values(tensors_[index], dequantise, &converted_[index]);
}

}  // namespace weir::heads
