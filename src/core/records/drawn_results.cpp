// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/drawn_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/records/map_summary.hpp"
#include "core/results/picture_coordinates.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::records {
namespace {

constexpr double kWhole = 1e9;  // beyond every picture

// The box of an object: its own, its parent's, or the whole picture.
Box make_box(const ResultFrame& frame, const ResultObject& object, const draw::Detections& drawn) {
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

draw::Detection make_detection(const ResultReader& reader, const ResultFrame& frame,
                               const ResultObject& object, draw::Detections* out) {
  const Box box = make_box(frame, object, *out);
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
// box itself, or the box has a text already. `drawn_rows` holds the drawn row of each object.
bool add_to_parent(const ResultFrame& frame, const ResultObject& object,
                   const std::vector<size_t>& drawn_rows, draw::Detections* out) {
  if (object.text.empty() || object.has_box || object.parent < 0) return false;
  const auto parent = static_cast<size_t>(object.parent);
  if (parent >= drawn_rows.size() || !frame.objects[parent].has_box) return false;
  draw::Detection& row = out->rows[drawn_rows[parent]];
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

// nullptr: the tensor has no source map.
const SourceMap* find_map(size_t tensor, std::span<const SourceMap> maps) {
  const size_t index = maps.size() == 1 ? 0 : tensor;
  return index < maps.size() ? &maps[index] : nullptr;
}

// A grid over the part of the picture that tensor `tensor` covers, upright: `get_value` gives the
// value of an element; outside of the tensor it is 0.
template <class ValueOf>
draw::ClassMap map_over(Size size, size_t tensor, std::span<const SourceMap> maps, Size picture,
                        const ValueOf& get_value) {
  draw::ClassMap out;
  out.x2 = picture.width > 0 ? picture.width : kWhole;
  out.y2 = picture.height > 0 ? picture.height : kWhole;
  const SourceMap* map = find_map(tensor, maps);
  const Box whole =
      map ? Box{0, 0, static_cast<float>(map->width), static_cast<float>(map->height)} : Box{};
  if (map) {
    const Box box = results::upright_box(*map, whole);
    out.x1 = box.x1, out.x2 = box.x2;
    out.y1 = box.y1, out.y2 = box.y2;
  }
  const size_t elements = size_t{size.width} * size.height;
  out.width = size.width, out.height = size.height;
  if (!map || elements == 0 || results::keeps_directions(*map)) {
    out.classes.resize(elements);
    for (size_t i = 0; i < elements; ++i) out.classes[i] = get_value(i);
    return out;
  }
  const results::RotatedGrid grid(*map, whole, size);
  out.width = grid.size().width, out.height = grid.size().height;
  for (uint32_t row = 0; row < out.height; ++row)
    for (uint32_t column = 0; column < out.width; ++column) {
      const auto place = grid.find_point(column, row);
      out.classes.push_back(place ? get_value(static_cast<size_t>(place->y) * size.width +
                                              static_cast<size_t>(place->x))
                                  : uint16_t{0});
    }
  return out;
}

// The least depth of the frame is level 0, the greatest one level 255.
draw::ClassMap make_levels(const DepthView& view, std::span<const SourceMap> maps, Size picture) {
  constexpr double kLevels = 255;
  const SourceMap* map = find_map(view.tensor, maps);
  const DepthRange range = range_of_depths(view, map ? std::optional(*map) : std::nullopt);
  const double span = double{range.max} - range.min;
  draw::ClassMap out =
      map_over({view.width, view.height}, view.tensor, maps, picture, [&](size_t i) -> uint16_t {
        const double depth = view.at(i);
        if (!(span > 0) || !std::isfinite(depth)) return 0;
        const double part = std::clamp((depth - range.min) / span, 0.0, 1.0);
        return static_cast<uint16_t>(std::lround(part * kLevels));
      });
  out.is_depth = true;
  return out;
}

}  // namespace

draw::ClassMap make_class_map(const ClassMapView& view, std::span<const SourceMap> maps,
                              Size picture) {
  return map_over({view.width, view.height}, view.tensor, maps, picture,
                  [&](size_t i) { return static_cast<uint16_t>(view.at(i)); });
}

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
  std::vector<size_t> drawn_rows;
  for (const ResultObject& object : frame.objects) {
    if (out.rows.size() == draw::kRowLimit) break;
    drawn_rows.push_back(out.rows.size());
    if (add_to_parent(frame, object, drawn_rows, &out)) continue;
    out.rows.push_back(make_detection(reader, frame, object, &out));
    add_points(frame, object, &out);
  }
  const Size picture{out.picture_width, out.picture_height};
  for (const ClassMapView& view : frame.class_maps)
    out.class_maps.push_back(make_class_map(view, maps, picture));
  for (const DepthView& view : frame.depths)
    out.class_maps.push_back(make_levels(view, maps, picture));
  for (const ZoneCount& count : frame.zone_counts) {
    if (count.class_index >= 0 || count.zone >= zone::kZoneLimit) continue;
    if (out.zone_totals.size() <= count.zone) out.zone_totals.resize(count.zone + 1);
    out.zone_totals[count.zone] = {count.inside, count.entered, count.forward, count.backward};
  }
  out.left_out.not_finite = frame.rows_not_finite;
  out.left_out.beyond_limit = frame.objects.size() - drawn_rows.size();
  return out;
}

}  // namespace weir::records
