// Writes and reads regions of interest.
//
// Elements that scale or crop a picture change a region's rectangle and know nothing of its
// parameters. So the structure `weir` has positions as parts of the rectangle: the box as four
// numbers, key points as x, y, score of each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/region_meta.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

using Meta = GstVideoRegionOfInterestMeta;

void set_numbers(GstStructure* structure, const char* field, std::span<const double> numbers) {
  GValue array = G_VALUE_INIT;
  gst_value_array_init(&array, static_cast<guint>(numbers.size()));
  for (const double number : numbers) {
    GValue value = G_VALUE_INIT;
    g_value_init(&value, G_TYPE_DOUBLE);
    g_value_set_double(&value, number);
    gst_value_array_append_and_take_value(&array, &value);
  }
  gst_structure_take_value(structure, field, &array);
}

std::vector<double> get_numbers(const GstStructure* structure, const char* field) {
  std::vector<double> out;
  const GValue* array = structure ? gst_structure_get_value(structure, field) : nullptr;
  if (!array || !GST_VALUE_HOLDS_ARRAY(array)) return out;
  for (guint i = 0; i < gst_value_array_get_size(array); ++i) {
    const GValue* value = gst_value_array_get_value(array, i);
    if (!G_VALUE_HOLDS_DOUBLE(value)) return {};
    out.push_back(g_value_get_double(value));
  }
  return out;
}

std::optional<double> get_number(const GstStructure* structure, const char* field) {
  double out = 0;
  if (!structure || !gst_structure_get_double(structure, field, &out) || !std::isfinite(out))
    return std::nullopt;
  return out;
}

std::optional<int> get_integer(const GstStructure* structure, const char* field) {
  int out = 0;
  if (!structure || !gst_structure_get_int(structure, field, &out)) return std::nullopt;
  return out;
}

void add_weir_parameter(Meta* meta, const PictureRegion& region,
                        std::optional<uint32_t> analytics_id) {
  const auto part_x = [meta](double x) { return (x - meta->x) / meta->w; };
  const auto part_y = [meta](double y) { return (y - meta->y) / meta->h; };
  GstStructure* out = gst_structure_new_empty("weir");
  const Box& box = region.box;
  set_numbers(out, "box", {{part_x(box.x1), part_y(box.y1), part_x(box.x2), part_y(box.y2)}});
  if (region.rotation != 0)
    gst_structure_set(out, "rotation", G_TYPE_DOUBLE, double{region.rotation}, nullptr);
  if (analytics_id)
    gst_structure_set(out, "analytics-id", G_TYPE_INT, static_cast<int>(*analytics_id), nullptr);
  std::vector<double> points;
  for (const auto& point : region.points)
    for (const double number : {part_x(point.x), part_y(point.y), double{point.score}})
      points.push_back(number);
  if (!points.empty()) set_numbers(out, "keypoints", points);
  gst_video_region_of_interest_meta_add_param(meta, out);
}

// The box in the picture: of `weir`; of `detection` where that is in the rectangle; the rectangle.
Box read_box(const Meta* meta, const GstStructure* weir, const GstStructure* detection,
             uint32_t width, uint32_t height) {
  const auto part = get_numbers(weir, "box");
  if (part.size() == 4)
    return {static_cast<float>(meta->x + part[0] * meta->w),
            static_cast<float>(meta->y + part[1] * meta->h),
            static_cast<float>(meta->x + part[2] * meta->w),
            static_cast<float>(meta->y + part[3] * meta->h)};
  const Box rectangle{static_cast<float>(meta->x), static_cast<float>(meta->y),
                      static_cast<float>(double(meta->x) + meta->w),
                      static_cast<float>(double(meta->y) + meta->h)};
  const auto x1 = get_number(detection, "x_min"), y1 = get_number(detection, "y_min");
  const auto x2 = get_number(detection, "x_max"), y2 = get_number(detection, "y_max");
  if (!x1 || !y1 || !x2 || !y2) return rectangle;
  const Box exact{static_cast<float>(*x1 * width), static_cast<float>(*y1 * height),
                  static_cast<float>(*x2 * width), static_cast<float>(*y2 * height)};
  // Parameters are of the picture in which the object was found: it may have been cropped since.
  const auto near = [](float a, float b) { return std::abs(a - b) <= 1; };
  return near(exact.x1, rectangle.x1) && near(exact.y1, rectangle.y1) &&
                 near(exact.x2, rectangle.x2) && near(exact.y2, rectangle.y2)
             ? exact
             : rectangle;
}

PictureRegion make_region(Meta* meta, uint32_t width, uint32_t height) {
  const GstStructure* detection = gst_video_region_of_interest_meta_get_param(meta, "detection");
  const GstStructure* object = gst_video_region_of_interest_meta_get_param(meta, "object_id");
  const GstStructure* weir = gst_video_region_of_interest_meta_get_param(meta, "weir");
  PictureRegion out;
  const char* label = g_quark_to_string(meta->roi_type);
  out.label = label ? label : "";
  out.box = read_box(meta, weir, detection, width, height);
  for (const char* field : {"score", "confidence"})
    if (const auto score = get_number(detection, field)) out.score = static_cast<float>(*score);
  out.class_index = std::max(get_integer(detection, "label_id").value_or(-1), -1);
  out.track = static_cast<uint32_t>(std::max(get_integer(object, "id").value_or(0), 0));
  out.rotation = static_cast<float>(get_number(weir, "rotation").value_or(0));
  if (const auto id = get_integer(weir, "analytics-id"); id && *id >= 0)
    out.analytics_id = static_cast<uint32_t>(*id);
  const auto points = get_numbers(weir, "keypoints");
  for (size_t i = 0; i + 3 <= points.size(); i += 3)
    out.points.push_back({static_cast<float>(meta->x + points[i] * meta->w),
                          static_cast<float>(meta->y + points[i + 1] * meta->h),
                          static_cast<float>(points[i + 2])});
  if (const char* model = detection ? gst_structure_get_string(detection, "model_name") : nullptr)
    out.model = model;
  return out;
}

}  // namespace

int next_region_id(GstBuffer* buffer) {
  int id = 0;
  gpointer state = nullptr;
  while (GstMeta* meta = gst_buffer_iterate_meta_filtered(
             buffer, &state, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE))
    id = std::max(id, reinterpret_cast<Meta*>(meta)->id);
  return id < G_MAXINT ? id + 1 : 1;
}

std::optional<Rect> visible_part(const Box& box, Size picture) {
  const auto within = [](double edge, uint32_t max) {
    return static_cast<uint32_t>(std::clamp(edge, 0.0, static_cast<double>(max)));
  };
  const uint32_t x = within(std::floor(box.x1), picture.width);
  const uint32_t y = within(std::floor(box.y1), picture.height);
  const uint32_t right = within(std::ceil(box.x2), picture.width);
  const uint32_t bottom = within(std::ceil(box.y2), picture.height);
  if (right <= x || bottom <= y) return std::nullopt;
  return Rect{x, y, right - x, bottom - y};
}

Meta* add_region(GstBuffer* buffer, const PictureRegion& region, const Rect& at, Size picture,
                 const RegionIds& ids) {
  Meta* meta = gst_buffer_add_video_region_of_interest_meta_id(buffer, make_quark(region.label),
                                                               at.x, at.y, at.width, at.height);
  meta->id = ids.id;
  meta->parent_id = ids.parent;
  GstStructure* detection =
      gst_structure_new("detection", "x_min", G_TYPE_DOUBLE, double{region.box.x1} / picture.width,
                        "y_min", G_TYPE_DOUBLE, double{region.box.y1} / picture.height, "x_max",
                        G_TYPE_DOUBLE, double{region.box.x2} / picture.width, "y_max",
                        G_TYPE_DOUBLE, double{region.box.y2} / picture.height, nullptr);
  if (region.score)
    gst_structure_set(detection, "confidence", G_TYPE_DOUBLE, double{*region.score}, "score",
                      G_TYPE_DOUBLE, double{*region.score}, nullptr);
  if (region.class_index >= 0)
    gst_structure_set(detection, "label_id", G_TYPE_INT, region.class_index, nullptr);
  if (!region.model.empty())
    gst_structure_set(detection, "model_name", G_TYPE_STRING, region.model.c_str(), nullptr);
  gst_video_region_of_interest_meta_add_param(meta, detection);
  if (region.track > 0)
    gst_video_region_of_interest_meta_add_param(
        meta,
        gst_structure_new("object_id", "id", G_TYPE_INT, static_cast<int>(region.track), nullptr));
  add_weir_parameter(meta, region, ids.analytics);
  return meta;
}

void add_region_label(Meta* region, const std::string& label, int32_t class_index, float score,
                      const std::string& model) {
  gst_video_region_of_interest_meta_add_param(
      region, gst_structure_new("classification", "label", G_TYPE_STRING, label.c_str(), "label_id",
                                G_TYPE_INT, class_index, "confidence", G_TYPE_DOUBLE, double{score},
                                "model_name", G_TYPE_STRING, model.c_str(), nullptr));
}

void add_region_text(Meta* region, const std::string& text, float score, const std::string& model) {
  gst_video_region_of_interest_meta_add_param(
      region,
      gst_structure_new("text", "label", G_TYPE_STRING, text.c_str(), "confidence", G_TYPE_DOUBLE,
                        double{score}, "model_name", G_TYPE_STRING, model.c_str(), nullptr));
}

std::vector<PictureRegion> get_regions(GstBuffer* buffer, uint32_t width, uint32_t height) {
  std::vector<PictureRegion> out;
  std::vector<int> parents;
  std::map<int, int32_t> number_of_id;
  gpointer state = nullptr;
  while (GstMeta* found = gst_buffer_iterate_meta_filtered(
             buffer, &state, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)) {
    auto* meta = reinterpret_cast<Meta*>(found);
    if (meta->w == 0 || meta->h == 0) continue;
    number_of_id.emplace(meta->id, static_cast<int32_t>(out.size()));
    parents.push_back(meta->parent_id);
    out.push_back(make_region(meta, width, height));
  }
  // The id 0 is that of regions without one.
  for (size_t i = 0; i < out.size(); ++i) {
    const auto parent = number_of_id.find(parents[i]);
    const bool exists = parents[i] != 0 && parent != number_of_id.end();
    if (exists && parent->second != static_cast<int32_t>(i)) out[i].parent = parent->second;
  }
  return out;
}

}  // namespace weir::gst
