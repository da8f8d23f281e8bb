// Sets source maps of results and makes frames without results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/result_output.hpp"

#include <algorithm>
#include <list>
#include <vector>

#include "core/results/empty_frame.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::gst {
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
  roles_ = caps ? roles_from_caps(caps) : ResultRoles();
}

Status ResultOutput::place(GstBuffer* out) {
  const auto given = source_maps(out);
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
  set_source_maps(out, std::move(maps));
  return ok();
}

Result<Ref<GstBuffer>> ResultOutput::empty_frame(const BufferLimit& limit) const {
  std::list<std::vector<std::byte>> tensors;
  const bool is_written = results::write_empty(
      roles_, [&](size_t bytes) { return std::span(tensors.emplace_back(bytes)); });
  if (!is_written) return Ref<GstBuffer>();
  std::vector<BufferPart> parts;
  size_t total = 0;
  for (const auto& tensor : tensors) {
    parts.push_back({{}, tensor});
    total += tensor.size();
  }
  if (auto status = limit.check(total); !status) return status.error();
  auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
  const auto allocate = [](size_t bytes) { return allocate_memory(bytes); };
  if (auto status = append_parts(parts, out.get(), allocate); !status) return status.error();
  return out;
}

Result<Ref<GstBuffer>> ResultOutput::frame_of_gap(GstEvent* gap, const BufferLimit& limit) const {
  GstClockTime time = 0, duration = 0;
  gst_event_parse_gap(gap, &time, &duration);
  if (!GST_CLOCK_TIME_IS_VALID(time)) return Ref<GstBuffer>();
  auto out = empty_frame(limit);
  if (!out || !*out) return out;
  GST_BUFFER_PTS(out->get()) = time;
  GST_BUFFER_DURATION(out->get()) = duration;
  return out;
}

}  // namespace weir::gst
