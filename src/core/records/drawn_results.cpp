// Copies objects, masks, texts and class maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/drawn_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/results/turned_grid.hpp"

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

// Each row has the same number of points; those that it does not have are not found.
void add_points(const ResultFrame& frame, const ResultObject& object, draw::Detections* out) {
  for (size_t i = 0; i < out->points_per_row; ++i) {
    const bool exists = i < object.n_points;
    const auto point = exists ? frame.points[object.first_point + i] : results::KeyPoint{};
    out->points.push_back(exists ? Point{point.x, point.y} : Point{NAN, NAN});
    out->point_scores.push_back(exists ? point.score : 0);
  }
}

// Elements outside of the class map are background.
void turn(const ClassMapView& view, const results::TurnedGrid& grid, draw::ClassMap* out) {
  out->width = grid.size().width, out->height = grid.size().height;
  for (uint32_t row = 0; row < out->height; ++row)
    for (uint32_t column = 0; column < out->width; ++column) {
      const auto place = grid.place_of(column, row);
      const size_t index =
          place ? static_cast<size_t>(place->y) * view.width + static_cast<size_t>(place->x) : 0;
      out->classes.push_back(place ? static_cast<uint16_t>(view.at(index)) : uint16_t{0});
    }
}

draw::ClassMap class_map_of(const ClassMapView& view, std::span<const SourceMap> maps,
                            const draw::Detections& drawn) {
  draw::ClassMap out;
  out.x2 = drawn.picture_width > 0 ? drawn.picture_width : kWhole;
  out.y2 = drawn.picture_height > 0 ? drawn.picture_height : kWhole;
  const size_t index = maps.size() == 1 ? 0 : view.tensor;
  if (index < maps.size()) {
    const SourceMap& map = maps[index];
    const Box whole{0, 0, static_cast<float>(map.width), static_cast<float>(map.height)};
    const Box box = results::upright_box(map, whole);
    out.x1 = box.x1, out.x2 = box.x2;
    out.y1 = box.y1, out.y2 = box.y2;
    if (!results::keeps_directions(map) && view.width > 0 && view.height > 0) {
      turn(view, results::TurnedGrid(map, whole, {view.width, view.height}), &out);
      return out;
    }
  }
  out.width = view.width, out.height = view.height;
  out.classes.resize(size_t{view.width} * view.height);
  for (size_t i = 0; i < out.classes.size(); ++i)
    out.classes[i] = static_cast<uint16_t>(view.at(i));
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
  for (const ResultObject& object : frame.objects) {
    if (out.rows.size() == draw::kRowLimit) break;
    out.rows.push_back(detection_of(reader, frame, object, &out));
    add_points(frame, object, &out);
  }
  for (const ClassMapView& view : frame.class_maps)
    out.class_maps.push_back(class_map_of(view, maps, out));
  out.left_out.not_finite = frame.rows_not_finite;
  out.left_out.beyond_limit = frame.objects.size() - out.rows.size();
  return out;
}

}  // namespace weir::records
