// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

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

std::pair<uint32_t, uint32_t> common(uint32_t begin, uint32_t length, int64_t from, int64_t size) {
  const int64_t low = std::max<int64_t>(begin, from);
  const int64_t high = std::min(int64_t{begin} + length, from + size);
  if (high <= low) return {begin, 0};
  return {static_cast<uint32_t>(low), static_cast<uint32_t>(high - low)};
}

}  // namespace

PictureBox make_upright(const PictureBox& box) noexcept {
  PictureBox out = box;
  out.rotation = 0;
  if (box.rotation == 0 || !std::isfinite(box.rotation)) return out;
  const double cosine = std::abs(std::cos(box.rotation)), sine = std::abs(std::sin(box.rotation));
  const double width = box.right - box.left, height = box.bottom - box.top;
  const double x = box.left + width / 2, y = box.top + height / 2;
  const double half_width = (width * cosine + height * sine) / 2;
  const double half_height = (width * sine + height * cosine) / 2;
  out.left = x - half_width, out.top = y - half_height;
  out.right = x + half_width, out.bottom = y + half_height;
  return out;
}

std::optional<PictureScale> find_scale(Size from, Size to, double pixel_aspect) noexcept {
  const bool are_known = from.width > 0 && from.height > 0 && to.width > 0 && to.height > 0;
  if (!are_known) return PictureScale{};
  const PictureScale scale{static_cast<double>(to.width) / from.width,
                           static_cast<double>(to.height) / from.height};
  if (to.width > from.width || to.height > from.height) return scale;
  // Sides are rounded to what a codec or a model accepts, unless one of them stays.
  constexpr double kRounding = 0.05;
  const bool keeps_side = to.width == from.width || to.height == from.height;
  const double tolerance = keeps_side ? 1.0 / std::min(to.width, to.height) : kRounding;
  const double ratio = scale.x / scale.y;
  const bool is_whole =
      std::abs(ratio - 1) <= tolerance || std::abs(ratio * pixel_aspect - 1) <= tolerance;
  return is_whole ? std::optional(scale) : std::nullopt;
}

Error boxes_of_another_view(Size from, Size to) {
  const auto text = [](Size size) {
    return std::to_string(size.width) + " x " + std::to_string(size.height);
  };
  return {.code = Code::SPEC_MISMATCH,
          .what =
              "the boxes of results are used as they are: their picture has other "
              "proportions, so this one may be a part of it",
          .offered = "results of a picture of " + text(from),
          .needed = text(to) +
                    " or the same proportions; crop=LEFT:TOP:WIDTH:HEIGHT of "
                    "tensor_preprocess cuts a part out of the whole picture"};
}

Roi make_region(const PictureBox& box, const RegionShape& shape, const PictureScale& scale) {
  const bool is_rotated = shape.follows_rotation && std::isfinite(box.rotation);
  PictureBox in = is_rotated ? box : make_upright(box);
  in.left *= scale.x, in.right *= scale.x, in.top *= scale.y, in.bottom *= scale.y;
  const double width = in.right - in.left, height = in.bottom - in.top;
  const bool has_area = box.right > box.left && box.bottom > box.top;  // else no shape has one
  Roi out;
  if (has_area)
    out = shape == RegionShape{} ? make_box(in.left, in.top, in.right, in.bottom)
                                 : make_shaped({in.left + width / 2, in.top + height / 2}, width,
                                               height, is_rotated ? box.rotation : 0, shape);
  out.row = box.row;
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

void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes,
                std::vector<PictureBox>* out) {
  out->clear();
  const bool are_floats = spec.type == ElementType::Float32;
  const size_t count = bytes.size() / (kNumbers * 4);
  for (size_t b = 0; b < count; ++b) {
    const auto of = bytes.subspan(b * kNumbers * 4);
    const auto at = [&](size_t i) {
      return are_floats ? static_cast<double>(number_at<float>(of, i))
                        : static_cast<double>(number_at<uint32_t>(of, i));
    };
    out->push_back({.left = at(0), .top = at(1), .right = at(0) + at(2), .bottom = at(1) + at(3)});
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
                       uint64_t first_row, std::vector<PictureBox>* out) {
  if (columns.box < 0) return;
  const size_t rows = bytes.size() / (size_t{columns.length} * sizeof(float));
  std::vector<float> numbers(columns.length);
  for (size_t i = 0; i < rows; ++i) {
    std::memcpy(numbers.data(), bytes.data() + i * columns.length * sizeof(float),
                columns.length * sizeof(float));
    const ResultRow row(columns, numbers.data());
    if (row.is_background()) continue;
    const weir::Box box = row.box();
    out->push_back({.left = double{box.x1},
                    .top = double{box.y1},
                    .right = double{box.x2},
                    .bottom = double{box.y2},
                    .rotation = double{row.rotation()},
                    .row = first_row + i + 1});
  }
}

Rect common_part(const Rect& whole, const Roi& box) noexcept {
  const auto [x, width] = common(whole.x, whole.width, box.x, box.width);
  const auto [y, height] = common(whole.y, whole.height, box.y, box.height);
  return {x, y, width, height};
}

}  // namespace weir::preprocess
