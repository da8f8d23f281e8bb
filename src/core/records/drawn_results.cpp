// Copies objects, masks, texts and class maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/drawn_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/records/map_summary.hpp"

namespace weir::records {
namespace {

constexpr double kWhole = 1e9;  // beyond every picture

// The box of an object: its own, its parent's, or the whole picture.
Box box_of(const ResultFrame& frame, const ResultObject& object, const draw::Detections& drawn) {
  const ResultObject* with_box = &object;
  for (size_t i = 0; !with_box->has_box && i < frame.objects.size(); ++i) {
    if (with_box->parent < 0 || static_cast<size_t>(with_box->parent) >= frame.objects.size())
      break;
    with_box = &frame.objects[static_cast<size_t>(with_box->parent)];
  }
  if (with_box->has_box) return with_box->box;
  return {0, 0, static_cast<float>(drawn.picture_width > 0 ? drawn.picture_width : kWhole),
          static_cast<float>(drawn.picture_height > 0 ? drawn.picture_height : kWhole)};
}

draw::Detection detection_of(const ResultReader& reader, const ResultFrame& frame,
                             const ResultObject& object, draw::Detections* out) {
  const Box box = box_of(frame, object, *out);
  draw::Detection drawn;
  drawn.x1 = box.x1, drawn.y1 = box.y1, drawn.x2 = box.x2, drawn.y2 = box.y2;
  drawn.score = object.score;
  drawn.class_index = static_cast<uint32_t>(std::max(object.class_index, 0));
  drawn.source = reader.groups()[object.group].source;
  drawn.track = object.track;
  drawn.rotation = object.rotation;
  drawn.is_label = !object.has_box;
  if (!object.text.empty()) {
    drawn.text = static_cast<int32_t>(out->texts.size());
    out->texts.emplace_back(object.text);
  }
  if (!object.mask.values.empty()) {
    drawn.mask = static_cast<int32_t>(out->masks.size());
    draw::DetectionMask mask{object.mask.width, object.mask.height, {}};
    mask.values.resize(object.mask.values.size());
    std::memcpy(mask.values.data(), object.mask.values.data(), mask.values.size());
    out->masks.push_back(std::move(mask));
  }
  return drawn;
}

// Writes a text at the box that was read, in place of the box's own label: false if the text has a
// box itself, or the box has a text already. `row_of` is the drawn row of each object.
bool add_to_parent(const ResultFrame& frame, const ResultObject& object,
                   const std::vector<size_t>& row_of, draw::Detections* out) {
  if (object.text.empty() || object.has_box || object.parent < 0) return false;
  const auto parent = static_cast<size_t>(object.parent);
  if (parent >= row_of.size() || !frame.objects[parent].has_box) return false;
  draw::Detection& row = out->rows[row_of[parent]];
  if (row.text >= 0) return false;
  row.text = static_cast<int32_t>(out->texts.size());
  row.score = object.score;
  out->texts.emplace_back(object.text);
  return true;
}

// Each row has the same number of points; those that it does not have are not found.
void add_points(const ResultFrame& frame, const ResultObject& object, draw::Detections* out) {
  for (size_t i = 0; i < out->points_per_row; ++i) {
    const bool exists = i < object.n_points;
    const auto point = exists ? frame.points[object.first_point + i] : results::KeyPoint{};
    out->points.push_back(exists ? Point{point.x, point.y} : Point{NAN, NAN});
    out->point_scores.push_back(exists ? point.score : 0);
  }
}

// An empty grid over the part of the picture that tensor `tensor` covers.
draw::ClassMap map_over(uint32_t width, uint32_t height, size_t tensor,
                        std::span<const SourceMap> maps, const draw::Detections& drawn) {
  draw::ClassMap out;
  out.x2 = drawn.picture_width > 0 ? drawn.picture_width : kWhole;
  out.y2 = drawn.picture_height > 0 ? drawn.picture_height : kWhole;
  const size_t index = maps.size() == 1 ? 0 : tensor;
  if (index < maps.size()) {
    const SourceMap& map = maps[index];
    const Point a = map.to_source({0, 0});
    const Point b = map.to_source({double(map.width), double(map.height)});
    out.x1 = std::min(a.x, b.x), out.x2 = std::max(a.x, b.x);
    out.y1 = std::min(a.y, b.y), out.y2 = std::max(a.y, b.y);
  }
  out.width = width, out.height = height;
  out.classes.resize(size_t{width} * height);
  return out;
}

draw::ClassMap class_map_of(const ClassMapView& view, std::span<const SourceMap> maps,
                            const draw::Detections& drawn) {
  draw::ClassMap out = map_over(view.width, view.height, view.tensor, maps, drawn);
  for (size_t i = 0; i < out.classes.size(); ++i)
    out.classes[i] = static_cast<uint16_t>(view.at(i));
  return out;
}

// The least depth of the frame is level 0, the greatest one level 255.
draw::ClassMap levels_of(const DepthView& view, std::span<const SourceMap> maps,
                         const draw::Detections& drawn) {
  constexpr double kLevels = 255;
  draw::ClassMap out = map_over(view.width, view.height, view.tensor, maps, drawn);
  out.is_depth = true;
  const size_t index = maps.size() == 1 ? 0 : view.tensor;
  const DepthRange range =
      range_of_depths(view, index < maps.size() ? std::optional(maps[index]) : std::nullopt);
  const double span = double{range.greatest} - range.least;
  for (size_t i = 0; i < out.classes.size(); ++i) {
    const double depth = view.at(i);
    if (span > 0 && std::isfinite(depth))
      out.classes[i] =
          static_cast<uint16_t>(std::clamp((depth - range.least) / span, 0.0, 1.0) * kLevels + 0.5);
  }
  return out;
}

}  // namespace

draw::Detections drawn_results(const ResultReader& reader, const ResultFrame& frame,
                               std::span<const SourceMap> maps) {
  draw::Detections out;
  if (!maps.empty()) {
    out.picture_width = maps[0].source_width;
    out.picture_height = maps[0].source_height;
  }
  out.scored = std::any_of(reader.groups().begin(), reader.groups().end(),
                           [](const RowGroup& group) { return group.columns.score >= 0; });
  for (const ResultObject& object : frame.objects)
    out.points_per_row = std::max<size_t>(out.points_per_row, object.n_points);
  std::vector<size_t> row_of;
  for (const ResultObject& object : frame.objects) {
    if (out.rows.size() == draw::kRowLimit) break;
    row_of.push_back(out.rows.size());
    if (add_to_parent(frame, object, row_of, &out)) continue;
    out.rows.push_back(detection_of(reader, frame, object, &out));
    add_points(frame, object, &out);
  }
  for (const ClassMapView& view : frame.class_maps)
    out.class_maps.push_back(class_map_of(view, maps, out));
  for (const DepthView& view : frame.depths) out.class_maps.push_back(levels_of(view, maps, out));
  out.left_out.not_finite = frame.rows_not_finite;
  out.left_out.beyond_limit = frame.objects.size() - row_of.size();
  return out;
}

}  // namespace weir::records
