// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/results_pad.hpp"

#include "core/records/drawn_results.hpp"
#include "core/zone/zone_file.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {

void ResultsPad::start(ResultsSync sync, Coordinates coordinates) {
  PairedTensors::start(sync);
  coordinates_ = coordinates;
  zones_.reset();
  for (auto* count :
       {&background_, &not_finite_, &without_area_, &beyond_limit_, &points_not_finite_})
    *count = 0;
}

// Streams with weir-columns have results in pixels of the source picture; others have rows as
// weir/detection.hpp defines them.
Status ResultsPad::accept(const FrameSpec& spec) {
  has_columns_ = !spec.roles.empty();
  if (has_columns_) {
    auto reader = records::ResultReader::make(columns_text(spec.roles), sources_text(spec.roles));
    if (!reader) return reader.error();
    reader_ = *std::move(reader);
    return spec.format == Format::Static ? reader_.check(spec.tensors) : ok();
  }
  if (spec.format != Format::Static) return ok();
  if (spec.tensors.size() == 1) return draw::check_detections(spec.tensors[0]);
  return draw::check_detections(TensorSpec{});
}

// A frame without tensors has no results.
Result<ResultsPad::Results> ResultsPad::read(GstBuffer* buffer,
                                             const std::vector<gst::TensorPlace>& tensors) {
  if (tensors.empty()) return std::make_shared<const draw::Detections>();
  if (has_columns_) return read_columns(buffer, tensors);
  const TensorSpec spec = tensors.size() == 1 ? tensors[0].spec : TensorSpec{};
  if (auto status = draw::check_detections(spec); !status) return status.error();
  std::span<const SourceMap> maps;
  if (coordinates_ == Coordinates::Tensor) {
    maps = gst::source_maps(buffer);
    if (maps.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the results have no source map to the picture",
                   .offered = "a frame without a source map",
                   .needed = "a source map, as tensor_converter or tensor_preprocess attaches it",
                   .fix = "tensor_overlay coordinates=picture"};
  }
  auto detections = draw::read_detections(spec, tensors[0].payload, maps);
  if (!detections) return detections.error();
  count(detections->left_out);
  return Results(std::make_shared<const draw::Detections>(*std::move(detections)));
}

Result<ResultsPad::Results> ResultsPad::read_columns(GstBuffer* buffer,
                                                     const std::vector<gst::TensorPlace>& tensors) {
  std::vector<records::ResultTensor> views;
  views.reserve(tensors.size());
  for (const auto& tensor : tensors) views.push_back({tensor.spec, tensor.payload});
  if (auto status = reader_.read(views, &frame_); !status) return status.error();
  auto detections = records::drawn_results(reader_, frame_, gst::source_maps(buffer));
  detections.names = names_;
  if (reader_.has_zones() && reader_.zone_source() == zone_source_) detections.zones = zones_;
  count(detections.left_out);
  return Results(std::make_shared<const draw::Detections>(std::move(detections)));
}

void ResultsPad::set_labels(const records::LabelsBySource& labels) {
  auto names = records::labels_of_sources(
      labels, has_columns_ ? reader_.sources() : std::vector<std::string>());
  names_ = names.empty() ? nullptr : std::make_shared<const draw::ClassNames>(std::move(names));
}

// Any element may have sent the event: zones that cannot be used are not drawn.
void ResultsPad::set_zones(const gst::ZonesOfSource& zones) {
  auto parsed = zone::parse_zones(zones.zones, "the event weir-zones");
  zone_source_ = zones.source;
  zones_ = parsed ? std::make_shared<const zone::ZoneSet>(*std::move(parsed)) : nullptr;
}

void ResultsPad::count(const draw::LeftOut& left_out) {
  background_ += left_out.background;
  not_finite_ += left_out.not_finite;
  without_area_ += left_out.without_area;
  beyond_limit_ += left_out.beyond_limit;
  points_not_finite_ += left_out.points_not_finite;
}

void ResultsPad::add_stats(GstStructure* stats) const {
  PairedTensors::add_stats(stats, "results-drawn");
  const auto add = [stats](const char* name, uint64_t value) {
    gst_structure_set(stats, name, G_TYPE_UINT64, value, nullptr);
  };
  add("rows-background", background_);
  add("rows-not-finite", not_finite_);
  add("rows-without-area", without_area_);
  add("rows-beyond-limit", beyond_limit_);
  add("points-not-finite", points_not_finite_);
}

}  // namespace weir
