// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_to_roi/roi_results_pad.hpp"

#include <set>

#include "core/records/drawn_results.hpp"
#include "gstcpp/buffer/analytics_meta.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace {

std::string text_field(const GstCaps* caps, const char* name) {
  const char* text = gst_structure_get_string(gst_caps_get_structure(caps, 0), name);
  return text ? text : "";
}

// GStreamer's texts are UTF-8.
std::string valid_text(std::string_view text) {
  gchar* made = g_utf8_make_valid(text.data(), static_cast<gssize>(text.size()));
  std::string out = made;
  g_free(made);
  return out;
}

// 0 and 1: whether a cell is more probably the object's than not.
gst::Segmentation make_segmentation(const records::ResultObject& object, std::string_view label) {
  results::RegionGrid grid{object.mask.width, object.mask.height, {}};
  for (const std::byte value : object.mask.values)
    grid.numbers.push_back(std::to_integer<uint16_t>(value >> 7));
  return {.mask = gst::make_mask(grid),
          .box = object.box,
          .labels = {{0, "background"}, {1, std::string(label)}}};
}

}  // namespace

void RoiResultsPad::start(ResultsSync sync, records::Labels labels, float threshold) {
  PairedTensors::start(sync);
  labels_ = std::move(labels);
  threshold_ = threshold;
  without_region_ = not_finite_ = 0;
}

Status RoiResultsPad::handle(GstEvent* event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const std::string columns = text_field(caps, WEIR_RESULTS_COLUMNS);
    auto reader = records::ResultReader::make(columns, text_field(caps, WEIR_RESULTS_SOURCE));
    if (!reader) return reader.error();
    reader_ = *std::move(reader);
    has_columns_ = !columns.empty();
  }
  return PairedTensors::handle(event);
}

Status RoiResultsPad::accept(const FrameSpec& spec) {
  return spec.format == Format::Static ? reader_.check(spec.tensors) : ok();
}

// A frame without tensors has no results.
Result<RoiResultsPad::Results> RoiResultsPad::read(GstBuffer* buffer,
                                                   const std::vector<gst::TensorPlace>& tensors) {
  auto out = std::make_shared<RegionResults>();
  if (tensors.empty()) return Results(std::move(out));
  std::vector<records::ResultTensor> views;
  views.reserve(tensors.size());
  for (const auto& tensor : tensors) views.push_back({tensor.spec, tensor.payload});
  if (auto status = reader_.read(views, &frame_); !status) return status.error();
  const auto maps = gst::source_maps(buffer);
  // Rows without columns are in pixels of the video, as tensor_overlay takes them.
  if (has_columns_ && !maps.empty())
    out->width = maps[0].source_width, out->height = maps[0].source_height;
  std::vector<int32_t> region_of(frame_.objects.size(), -1);
  for (const auto& object : frame_.objects) add_object(frame_, object, &region_of, out.get());
  if constexpr (gst::kHasSegmentation)
    for (const auto& map : frame_.class_maps) out->class_maps.push_back(read_class_map(map, maps));
  not_finite_ += frame_.rows_not_finite;
  return Results(std::move(out));
}

void RoiResultsPad::set_labels(const records::LabelsBySource& labels) {
  labels_of_stream_ = records::Labels(records::labels_of_sources(labels, reader_.sources()));
}

void RoiResultsPad::add_object(const records::ResultFrame& frame,
                               const records::ResultObject& object, std::vector<int32_t>* region_of,
                               RegionResults* out) {
  if (!(object.score >= threshold_)) return;
  const auto index = static_cast<size_t>(&object - frame.objects.data());
  const records::RowGroup& group = reader_.groups()[object.group];
  const bool is_text = group.kind() == records::RowKind::Text;
  std::string number;
  const std::string_view label =
      object.class_index >= 0 ? labels().of(group.source, object.class_index, &number) : "";
  const int32_t parent = object.parent >= 0 ? (*region_of)[static_cast<size_t>(object.parent)] : -1;
  if (object.has_box) {
    (*region_of)[index] = static_cast<int32_t>(out->regions.size());
    const auto* points = frame.points.data() + object.first_point;
    out->regions.push_back({.label = std::string(label),
                            .box = object.box,
                            .score = object.score,
                            .class_index = object.class_index,
                            .track = object.track,
                            .rotation = object.rotation,
                            .parent = parent,
                            .points = {points, points + object.n_points},
                            .model = reader_.sources()[group.source]});
    if (gst::kHasSegmentation && !object.mask.values.empty())
      out->regions.back().mask = make_segmentation(object, label);
  }
  const int32_t region = object.has_box ? (*region_of)[index] : parent;
  if (object.has_box && !is_text) return;
  if (region < 0) ++without_region_;
  out->labels.push_back({.region = region,
                         .is_text = is_text,
                         .text = is_text ? valid_text(object.text) : std::string(label),
                         .model = reader_.sources()[group.source],
                         .class_index = object.class_index,
                         .score = object.score});
}

const records::Labels& RoiResultsPad::labels() const noexcept {
  return labels_.empty() ? labels_of_stream_ : labels_;
}

gst::Segmentation RoiResultsPad::read_class_map(const records::ClassMapView& view,
                                                std::span<const SourceMap> maps) const {
  const Size picture = maps.empty() ? Size{} : Size{maps[0].source_width, maps[0].source_height};
  auto map = records::make_class_map(view, maps, picture);
  results::RegionGrid grid{map.width, map.height, std::move(map.classes)};
  gst::Segmentation out{.box = {0, 0, 1, 1}};
  if (picture.width > 0 && picture.height > 0) {
    Box part{static_cast<float>(map.x1), static_cast<float>(map.y1), static_cast<float>(map.x2),
             static_cast<float>(map.y2)};
    grid = results::crop(std::move(grid), picture, &part);
    const auto width = static_cast<float>(picture.width);
    const auto height = static_cast<float>(picture.height);
    out.box = {part.x1 / width, part.y1 / height, part.x2 / width, part.y2 / height};
  }
  if (grid.numbers.empty()) return out;
  std::string number;
  for (const uint16_t index : std::set(grid.numbers.begin(), grid.numbers.end()))
    out.labels[index] = labels().of(view.source, index, &number);
  out.mask = gst::make_mask(grid);
  return out;
}

void RoiResultsPad::add_stats(GstStructure* stats) const {
  PairedTensors::add_stats(stats, "results-used");
  gst_structure_set(stats, "rows-without-region", G_TYPE_UINT64, without_region_.load(),
                    "rows-not-finite", G_TYPE_UINT64, not_finite_.load(), nullptr);
}

}  // namespace weir
