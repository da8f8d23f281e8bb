// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/detections.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "weir/detection.hpp"

namespace weir::draw {
namespace {

using Row = DetectionRow<const float>;

constexpr uint32_t kBox = 4, kScore = 4;  // numbers of a box; index of the score
constexpr uint32_t kFixed = Row::kFixed;

bool fits(uint32_t k) {
  return k >= kBox && k <= kNumberLimit && (k <= kFixed || (k - kFixed) % 2 == 0);
}

bool finite(std::span<const float> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](float n) { return std::isfinite(n); });
}

void move_box(const SourceMap& map, Detection* box) {
  double xs[4] = {}, ys[4] = {};
  size_t i = 0;
  for (const double x : {box->x1, box->x2})
    for (const double y : {box->y1, box->y2}) {
      const Point corner = map.to_source({x, y});
      xs[i] = corner.x;
      ys[i++] = corner.y;
    }
  box->x1 = *std::min_element(xs, xs + 4);
  box->x2 = *std::max_element(xs, xs + 4);
  box->y1 = *std::min_element(ys, ys + 4);
  box->y2 = *std::max_element(ys, ys + 4);
}

uint32_t to_class(float number) {
  return static_cast<uint32_t>(std::clamp(std::floor(number + 0.5), 0.0, 4294967295.0));
}

// Short rows get score 1 and class 0.
Detection to_detection(std::span<const float> numbers) {
  float fixed[kFixed] = {0, 0, 0, 0, 1, 0};
  std::copy_n(numbers.begin(), std::min<size_t>(numbers.size(), kFixed), fixed);
  const Row row(fixed);
  const Box box = row.box();
  Detection out;
  out.x1 = box.x1, out.y1 = box.y1, out.x2 = box.x2, out.y2 = box.y2;
  out.score = row.score();
  out.class_index = to_class(row.class_index());
  return out;
}

void add_points(const Row& row, const SourceMap* map, Detections* out) {
  for (size_t i = 0; i < row.key_points(); ++i) {
    Point point{row.x(i), row.y(i)};
    if (map) point = map->to_source(point);
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) ++out->left_out.points_not_finite;
    out->points.push_back(point);
  }
}

// The counter for a rejected row; null for a detection.
uint64_t* left_out(std::span<const float> row, const SourceMap* map, Detection* found,
                   LeftOut* counts) {
  if (row.size() > kScore && row[kScore] <= 0) return &counts->background;
  if (!finite(row.first(std::min<size_t>(row.size(), kFixed)))) return &counts->not_finite;
  *found = to_detection(row);
  if (row[0] >= row[2] || row[1] >= row[3]) return &counts->without_area;
  if (map) move_box(*map, found);
  if (!std::isfinite(found->x2 - found->x1 + found->y2 - found->y1)) return &counts->not_finite;
  if (found->x1 >= found->x2 || found->y1 >= found->y2) return &counts->without_area;
  return nullptr;
}

void add_row(std::span<const float> row, const SourceMap* map, Detections* out) {
  Detection found;
  if (uint64_t* count = left_out(row, map, &found, &out->left_out)) {
    ++*count;
    return;
  }
  out->rows.push_back(found);
  if (row.size() > kFixed) add_points(Row(row), map, out);
}

Error wrong_number_of_maps(size_t maps, uint64_t rows) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the number of source maps differs from the number of rows",
               .offered = std::to_string(maps) + " source maps",
               .needed = "one, or one for each of " + std::to_string(rows) + " rows",
               .fix = "tensor_overlay coordinates=picture"};
}

}  // namespace

Status check_detections(const TensorSpec& spec) {
  bool flat = spec.shape.valid() && fits(spec.shape[0]);
  for (size_t i = 2; i < spec.shape.rank(); ++i) flat = flat && spec.shape[i] == 1;
  if (flat && spec.type == ElementType::Float32) return ok();
  return Error{
      .code = Code::SPEC_MISMATCH,
      .what = "the stream of results does not contain boxes",
      .offered = spec.to_string(),
      .needed =
          "one tensor float32 K:N: rows of x1, y1, x2, y2, then score, class, and x, y of key "
          "points, so that K is 4, 5, 6, 8, 10, ...",
      // Other dimensions are those of a model's outputs.
      .fix =
          flat ? "tensor_transform mode=typecast option=float32" : "tensor_decoder mode=detection"};
}

Result<Detections> read_detections(const TensorSpec& spec, std::span<const std::byte> bytes,
                                   std::span<const SourceMap> maps) {
  const size_t numbers = spec.shape[0];
  const size_t rows = bytes.size() / (numbers * sizeof(float));
  if (maps.size() > 1 && maps.size() != rows) return wrong_number_of_maps(maps.size(), rows);
  Detections out;
  out.points_per_row = numbers > kFixed ? (numbers - kFixed) / 2 : 0;
  out.scored = numbers > kScore;
  if (!maps.empty()) {
    out.picture_width = maps[0].source_width;
    out.picture_height = maps[0].source_height;
  }
  const size_t taken = std::min<size_t>(rows, kRowLimit);
  out.left_out.beyond_limit = rows - taken;
  std::vector<float> row(numbers);
  for (size_t i = 0; i < taken; ++i) {
    std::memcpy(row.data(), bytes.data() + i * numbers * sizeof(float), numbers * sizeof(float));
    const SourceMap* map = maps.empty() ? nullptr : &maps[maps.size() == 1 ? 0 : i];
    add_row(row, map, &out);
  }
  return out;
}

}  // namespace weir::draw
