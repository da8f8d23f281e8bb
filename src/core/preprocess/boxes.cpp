// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "weir/results.hpp"
#include "weir/source_map.hpp"

namespace weir::preprocess {
namespace {

constexpr size_t kNumbers = 4;

template <class Number>
Number number_at(std::span<const std::byte> bytes, size_t index) {
  Number out;
  std::memcpy(&out, bytes.data() + index * sizeof(Number), sizeof(Number));
  return out;
}

// Of the left upper corner and the sides.
Roi make_box(double left, double top, double right, double bottom) {
  constexpr double kFar = 1e12;  // pixels; larger coordinates make no difference
  for (const double number : {left, top, right, bottom})
    if (!std::isfinite(number)) return {};
  const auto edge = [&](double at) -> int64_t { return std::llround(std::clamp(at, -kFar, kFar)); };
  const int64_t x = edge(left), y = edge(top);
  const int64_t width = edge(right) - x, height = edge(bottom) - y;
  if (width <= 0 || height <= 0) return {};
  return {x, y, width, height};
}

// A box of these sides around a centre, in the shape.
Roi make_shaped(Point centre, double width, double height, double rotation,
                const RegionShape& shape) {
  const double cosine = std::cos(rotation), sine = std::sin(rotation);
  const double right = width * shape.shift_x, down = height * shape.shift_y;
  const double x = centre.x + right * cosine - down * sine;
  const double y = centre.y + right * sine + down * cosine;
  if (shape.is_square) width = height = std::max(width, height);
  const double reach_x = width * shape.scale / 2, reach_y = height * shape.scale / 2;
  Roi out = make_box(x - reach_x, y - reach_y, x + reach_x, y + reach_y);
  if (out.width > 0) out.rotation = rotation;
  return out;
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

Roi make_region(const weir::Box& box, float rotation, const RegionShape& shape) {
  const bool is_rotated = shape.follows_rotation && std::isfinite(rotation);
  const weir::Box upright = is_rotated ? box : around(box, rotation);
  const double width = double{upright.x2 - upright.x1}, height = double{upright.y2 - upright.y1};
  if (shape == RegionShape{})
    return make_box(upright.x1, upright.y1, upright.x1 + width, upright.y1 + height);
  return make_shaped({upright.x1 + width / 2, upright.y1 + height / 2}, width, height,
                     is_rotated ? double{rotation} : 0, shape);
}

Roi make_region(const Roi& region, const RegionShape& shape) {
  if (shape == RegionShape{} || region.width <= 0 || region.height <= 0) return region;
  const auto width = static_cast<double>(region.width), height = static_cast<double>(region.height);
  Roi out = make_shaped(
      {static_cast<double>(region.x) + width / 2, static_cast<double>(region.y) + height / 2},
      width, height, 0, shape);
  out.row = region.row;
  return out;
}

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

void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes, std::vector<Roi>* out,
                const RegionShape& shape) {
  out->clear();
  const size_t count = bytes.size() / (kNumbers * 4);
  for (size_t b = 0; b < count; ++b) {
    const auto of = bytes.subspan(b * kNumbers * 4);
    if (spec.type == ElementType::Float32) {
      float numbers[kNumbers];
      for (size_t i = 0; i < kNumbers; ++i) numbers[i] = number_at<float>(of, i);
      const auto& [x, y, width, height] = numbers;
      out->push_back(make_region(make_box(x, y, double{x} + width, double{y} + height), shape));
      continue;
    }
    const auto at = [&](size_t i) { return int64_t{number_at<uint32_t>(of, i)}; };
    out->push_back(make_region(Roi{at(0), at(1), at(2), at(3)}, shape));
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
                       uint64_t first_row, std::vector<Roi>* out, const RegionShape& shape) {
  if (columns.box < 0) return;
  const size_t rows = bytes.size() / (size_t{columns.length} * sizeof(float));
  std::vector<float> numbers(columns.length);
  for (size_t i = 0; i < rows; ++i) {
    std::memcpy(numbers.data(), bytes.data() + i * columns.length * sizeof(float),
                columns.length * sizeof(float));
    const ResultRow row(columns, numbers.data());
    if (row.is_background()) continue;
    out->push_back(make_region(row.box(), row.rotation(), shape));
    out->back().row = first_row + i + 1;
  }
}

std::vector<Roi> scaled_to(Size picture, const PictureRegions& regions) {
  const Size from = regions.picture;
  const bool are_known = from.width > 0 && from.height > 0 && picture.width > 0;
  if (!are_known || from == picture) return regions.boxes;
  const double scale_x = static_cast<double>(picture.width) / from.width;
  const double scale_y = static_cast<double>(picture.height) / from.height;
  std::vector<Roi> out;
  for (const Roi& box : regions.boxes) {
    const double x = static_cast<double>(box.x) * scale_x, y = static_cast<double>(box.y) * scale_y;
    out.push_back(make_box(x, y, x + static_cast<double>(box.width) * scale_x,
                           y + static_cast<double>(box.height) * scale_y));
    out.back().row = box.row;
    out.back().rotation = box.rotation;
  }
  return out;
}

Rect common_part(const Rect& whole, const Roi& box) noexcept {
  const auto [x, width] = common(whole.x, whole.width, box.x, box.width);
  const auto [y, height] = common(whole.y, whole.height, box.y, box.height);
  return {x, y, width, height};
}

}  // namespace weir::preprocess
