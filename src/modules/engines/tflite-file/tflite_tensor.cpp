// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/tflite_tensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace weir::engine {
namespace {

constexpr uint64_t kTensorBytesLimit = uint64_t{1} << 31;

// Bytes per element in the order of TensorType; 0: no fixed size.
constexpr std::array<uint8_t, 18> kElementBytes{4, 2, 4,  1, 8, 0, 1, 2, 8,
                                                1, 8, 16, 8, 0, 0, 4, 2, 1};
constexpr uint8_t kInt4 = 17;  // two elements per byte

using Shape = std::vector<int32_t>;

bool quantization_fits(const FlatTable& table, const Shape& shape) {
  if (!table) return true;
  table.vector(0, 4);
  table.vector(1, 4);
  const FlatVector scale = table.vector(2, 4), zero_point = table.vector(3, 8);
  if (table.scalar<uint8_t>(4, 0) == 1) table.table(5).vector(0, 1);
  const auto axis = table.scalar<int32_t>(6, 0);
  for (uint32_t i = 0; i < scale.size(); ++i)
    if (const auto value = scale.scalar<float>(i); !std::isfinite(value) || value < 0) return false;
  if (scale.size() <= 1) return zero_point.size() <= 1;
  return axis >= 0 && static_cast<size_t>(axis) < shape.size() &&
         static_cast<int64_t>(scale.size()) == shape[static_cast<size_t>(axis)] &&
         (zero_point.size() == 0 || zero_point.size() == scale.size());
}

bool are_below(const FlatVector& indices, uint32_t limit) {
  for (uint32_t i = 0; i < indices.size(); ++i)
    if (indices.scalar<uint32_t>(i) >= limit) return false;
  return true;
}

// A union: its kind is in `field`, its table in the next one. Visits its numbers.
bool is_index_vector(const FlatTable& dimension, uint32_t field) {
  constexpr std::array<uint32_t, 4> kBytes{0, 4, 2, 1};  // none, int32, uint16, uint8
  const auto kind = dimension.scalar<uint8_t>(field, 0);
  if (kind >= kBytes.size()) return false;
  if (kind > 0) dimension.table(field + 1).vector(0, kBytes[kind]);
  return true;
}

bool sparsity_fits(const FlatTable& table, const Shape& shape) {
  if (!table) return true;
  const auto rank = static_cast<uint32_t>(shape.size());
  const FlatVector order = table.vector(0, 4), blocks = table.vector(1, 4);
  const FlatVector dimensions = table.vector(2, 4);
  if (order.size() != rank + blocks.size() || dimensions.size() != order.size()) return false;
  if (order.size() > 2 * kTfliteRankLimit) return false;
  if (!are_below(order, order.size()) || !are_below(blocks, rank)) return false;
  for (uint32_t i = 0; i < dimensions.size(); ++i)
    for (const uint32_t field : {2u, 4u})
      if (!is_index_vector(dimensions.table(i), field)) return false;
  return true;
}

// Empty when the tensor would exceed the limit.
std::optional<uint64_t> count_bytes(uint8_t type, const Shape& shape) {
  uint64_t bytes = std::max<uint64_t>(kElementBytes[type], 1);
  for (const int32_t extent : shape) {
    if (extent < 0) return std::nullopt;
    bytes *= static_cast<uint64_t>(extent);
    if (bytes > kTensorBytesLimit) return std::nullopt;
  }
  return bytes;
}

}  // namespace

Error tflite_damage(const FlatFile& file, const std::string& finding) {
  return {.code = Code::MODEL_INVALID,
          .what = "the file is truncated, damaged or not a TensorFlow Lite model",
          .offered = file.damaged()
                         ? "an offset or length is outside the file: it was truncated or changed"
                         : finding,
          .needed = "a complete .tflite model",
          .fix = "download or export the model again, then check it with weir inspect MODEL"};
}

Result<TfliteTensor> check_tflite_tensor(FlatFile* file, const FlatTable& tensor,
                                         std::span<const FlatVector> buffers) {
  const FlatVector extents = tensor.vector(0, 4), signature = tensor.vector(7, 4);
  const auto type = tensor.scalar<uint8_t>(1, 0);
  const auto buffer = tensor.scalar<uint32_t>(2, 0);
  tensor.string(3);
  const auto damage = [file](const std::string& finding) { return tflite_damage(*file, finding); };
  if (file->damaged()) return damage("");
  if (type >= kElementBytes.size()) return damage("element type " + std::to_string(type));
  if (buffer >= buffers.size()) return damage("a tensor names a buffer that does not exist");
  if (extents.size() > kTfliteRankLimit || signature.size() > kTfliteRankLimit)
    return damage("a tensor of rank " + std::to_string(std::max(extents.size(), signature.size())));
  if (signature.size() > 0 && signature.size() != extents.size())
    return damage("a tensor with two ranks");
  Shape shape;
  for (uint32_t i = 0; i < extents.size(); ++i) shape.push_back(extents.scalar<int32_t>(i));
  const auto bytes = count_bytes(type, shape);
  if (!bytes) return damage("a tensor with an impossible shape");
  const FlatTable sparsity = tensor.table(6);
  const uint32_t stored = buffers[buffer].size();
  const bool of_fixed_size = kElementBytes[type] > 0 && type != kInt4 && !sparsity;
  if (stored > 0 && of_fixed_size && stored != *bytes)
    return damage("the value of a tensor has " + std::to_string(stored) + " bytes instead of " +
                  std::to_string(*bytes));
  if (!quantization_fits(tensor.table(4), shape) || !sparsity_fits(sparsity, shape))
    return damage("the quantisation or sparsity of a tensor does not fit its shape");
  if (file->damaged()) return damage("");
  return TfliteTensor{
      .variable = tensor.scalar<uint8_t>(5, 0) != 0, .constant = stored > 0, .empty = *bytes == 0};
}

}  // namespace weir::engine
