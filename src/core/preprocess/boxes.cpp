// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "weir/results.hpp"

namespace weir::preprocess {
namespace {

constexpr size_t kNumbers = 4;

template <class Number>
Number number_at(std::span<const std::byte> bytes, size_t index) {
  Number out;
  std::memcpy(&out, bytes.data() + index * sizeof(Number), sizeof(Number));
  return out;
}

Roi make_box(const float (&n)[kNumbers]) {
  constexpr double kFar = 1e12;  // pixels; larger coordinates make no difference
  for (const float number : n)
    if (!std::isfinite(number)) return {};
  const auto edge = [&](double at) -> int64_t { return std::llround(std::clamp(at, -kFar, kFar)); };
  const int64_t x = edge(n[0]), y = edge(n[1]);
  const int64_t width = edge(double{n[0]} + n[2]) - x, height = edge(double{n[1]} + n[3]) - y;
  if (width <= 0 || height <= 0) return {};
  return {x, y, width, height};
}

// The upright box around `box`, rotated about its centre.
weir::Box around(const weir::Box& box, float rotation) {
  if (rotation == 0 || !std::isfinite(rotation)) return box;
  const float cosine = std::abs(std::cos(rotation)), sine = std::abs(std::sin(rotation));
  const float width = box.x2 - box.x1, height = box.y2 - box.y1;
  const float x = box.x1 + width / 2, y = box.y1 + height / 2;
  const float half_width = (width * cosine + height * sine) / 2;
  const float half_height = (width * sine + height * cosine) / 2;
  return {x - half_width, y - half_height, x + half_width, y + half_height};
}

std::pair<uint32_t, uint32_t> common(uint32_t begin, uint32_t length, int64_t from, int64_t size) {
  const int64_t low = std::max<int64_t>(begin, from);
  const int64_t high = std::min(int64_t{begin} + length, from + size);
  if (high <= low) return {begin, 0};
  return {static_cast<uint32_t>(low), static_cast<uint32_t>(high - low)};
}

}  // namespace

Status check_boxes(const TensorSpec& spec) {
  bool flat = spec.shape.valid() && spec.shape[0] == kNumbers;
  for (size_t i = 2; i < spec.shape.rank(); ++i) flat = flat && spec.shape[i] == 1;
  if (flat && (spec.type == ElementType::UInt32 || spec.type == ElementType::Float32)) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the stream of regions does not contain boxes",
               .offered = spec.to_string(),
               .needed = "one tensor uint32 4:N or float32 4:N: x, y, width and height of each box",
               .fix = "tensor_transform mode=typecast option=float32"};
}

void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes, std::vector<Roi>* out) {
  out->clear();
  const size_t count = bytes.size() / (kNumbers * 4);
  for (size_t b = 0; b < count; ++b) {
    const auto of = bytes.subspan(b * kNumbers * 4);
    if (spec.type == ElementType::Float32) {
      float numbers[kNumbers];
      for (size_t i = 0; i < kNumbers; ++i) numbers[i] = number_at<float>(of, i);
      out->push_back(make_box(numbers));
      continue;
    }
    const auto at = [&](size_t i) { return int64_t{number_at<uint32_t>(of, i)}; };
    out->push_back({at(0), at(1), at(2), at(3)});
  }
}

Status check_result_rows(const TensorSpec& spec, const weir_result_columns& columns) {
  bool flat = spec.shape.valid() && spec.shape[0] == columns.length;
  for (size_t i = 2; i < spec.shape.rank(); ++i) flat = flat && spec.shape[i] == 1;
  if (flat && spec.type == ElementType::Float32) return ok();
  return Error{
      .code = Code::SPEC_MISMATCH,
      .what = "the tensor of results does not have the columns that its caps define",
      .offered = spec.to_string(),
      .needed = "float32 " + std::to_string(columns.length) + ":N, as weir-columns defines it"};
}

void read_result_boxes(const weir_result_columns& columns, std::span<const std::byte> bytes,
                       uint64_t first_row, std::vector<Roi>* out) {
  if (columns.box < 0) return;
  const size_t rows = bytes.size() / (size_t{columns.length} * sizeof(float));
  std::vector<float> numbers(columns.length);
  for (size_t i = 0; i < rows; ++i) {
    std::memcpy(numbers.data(), bytes.data() + i * columns.length * sizeof(float),
                columns.length * sizeof(float));
    const ResultRow row(columns, numbers.data());
    if (row.is_background()) continue;
    const weir::Box upright = around(row.box(), row.rotation());
    const float corner[kNumbers] = {upright.x1, upright.y1, upright.x2 - upright.x1,
                                    upright.y2 - upright.y1};
    out->push_back(make_box(corner));
    out->back().row = first_row + i + 1;
  }
}

Rect common_part(const Rect& whole, const Roi& box) noexcept {
  const auto [x, width] = common(whole.x, whole.width, box.x, box.width);
  const auto [y, height] = common(whole.y, whole.height, box.y, box.height);
  return {x, y, width, height};
}

}  // namespace weir::preprocess
