// Sets source maps of results and makes frames without results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/result_output.hpp"

#include <algorithm>
#include <new>

#include "core/results/empty_frame.hpp"
#include "elements/tensor_decoder/buffer_sink.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace {

bool is_map(const ResultRole& role) {
  return role.columns == "class-map" || role.columns == "depth";
}

// `input` for a grid of W:H over the same pixels.
SourceMap map_of_grid(const SourceMap& input, const TensorSpec& grid) {
  const uint32_t width = std::max(grid.shape[0], 1u), height = std::max(grid.shape[1], 1u);
  SourceMap out = input.of_part(double{1} * input.width / width, 0,
                                double{1} * input.height / height, 0, width, height);
  out.x_dimension = 0;
  out.y_dimension = 1;
  return out;
}

}  // namespace

void ResultOutput::configure(const GstCaps* caps) {
  roles_ = caps ? gst::roles_from_caps(caps) : ResultRoles();
}

Status ResultOutput::place(GstBuffer* out) {
  const auto given = gst::source_maps(out);
  if (given.empty()) return ok();
  const SourceMap input = given[0];
  const SourceMap picture = picture_as_it_is(input.source_width, input.source_height, true);
  std::vector<SourceMap> maps{picture};
  if (std::any_of(roles_.begin(), roles_.end(), is_map)) {
    if (auto status = reader_.read(out, {Format::Flexible, {}, {}}); !status) return status;
    const auto& tensors = reader_.tensors();
    maps.assign(tensors.size(), picture);
    for (size_t i = 0; i < std::min(tensors.size(), roles_.size()); ++i)
      if (is_map(roles_[i])) maps[i] = map_of_grid(input, tensors[i].spec);
    reader_.clear();
  }
  gst::set_source_maps(out, std::move(maps));
  return ok();
}

Result<gst::Ref<GstBuffer>> ResultOutput::empty_frame(const BufferLimit& limit,
                                                      Ledger* ledger) const {
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  BufferSink sink(nullptr, out.get(), nullptr, limit, ledger);
  const bool is_written = results::write_empty(roles_, [&](size_t bytes) {
    void* const memory = sink.reserve(bytes);
    if (!memory) throw std::bad_alloc();
    return std::span(static_cast<std::byte*>(memory), bytes);
  });
  if (!is_written) return gst::Ref<GstBuffer>();
  if (auto status = sink.finish(); !status) return status.error();
  return out;
}

Result<gst::Ref<GstBuffer>> ResultOutput::frame_of_gap(GstEvent* gap, const BufferLimit& limit,
                                                       Ledger* ledger) const {
  GstClockTime time = 0, duration = 0;
  gst_event_parse_gap(gap, &time, &duration);
  if (!GST_CLOCK_TIME_IS_VALID(time)) return gst::Ref<GstBuffer>();
  auto out = empty_frame(limit, ledger);
  if (!out || !*out) return out;
  GST_BUFFER_PTS(out->get()) = time;
  GST_BUFFER_DURATION(out->get()) = duration;
  return out;
}

}  // namespace weir
