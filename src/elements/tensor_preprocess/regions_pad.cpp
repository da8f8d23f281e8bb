// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/regions_pad.hpp"

#include <algorithm>

#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {

void RegionsPad::start() {
  queue_.clear();
  queue_.flush(false);
}

// Pictures are not flushed with it; they continue without boxes.
void RegionsPad::flush(bool on) {
  on ? queue_.end() : queue_.clear();
}

Status RegionsPad::accept(const FrameSpec& spec) {
  results_.reset();
  if (!spec.roles.empty()) {
    auto results = gst::ResultBoxes::parse(spec);
    if (!results) return results.error();
    results_ = *std::move(results);
    return ok();
  }
  if (spec.format != Format::Static) return ok();
  if (spec.tensors.size() != 1)
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the stream of regions does not contain boxes",
        .offered = spec.to_string(),
        .needed = "one tensor uint32 4:N or float32 4:N: x, y, width and height of each box",
        .difference = "number of tensors"};
  return preprocess::check_boxes(spec.tensors[0]);
}

// A frame without tensors has no boxes. Boxes without a time match no picture; before the first
// picture they count as unused.
Status RegionsPad::push(GstBuffer* buffer, const std::vector<gst::TensorPlace>& tensors,
                        int64_t time) {
  std::vector<preprocess::PictureBox> boxes;
  if (results_) {
    if (auto status = results_->read(tensors, &boxes); !status) return status;
    const auto maps = gst::source_maps(buffer);
    const Size picture = maps.empty() ? Size{} : Size{maps[0].source_width, maps[0].source_height};
    queue_.push(time, {std::move(boxes), picture});
    return ok();
  }
  if (tensors.size() > 1) return preprocess::check_boxes(TensorSpec{});
  if (!tensors.empty()) {
    if (auto status = preprocess::check_boxes(tensors[0].spec); !status) return status;
    preprocess::read_boxes(tensors[0].spec, tensors[0].payload, &boxes);
  }
  queue_.push(time, {std::move(boxes), {}});
  return ok();
}

sync::TimedOutcome RegionsPad::take(GstClockTime time, GstClockTime max,
                                    preprocess::PictureRegions* out) {
  constexpr GstClockTime kMax = GstClockTime{24} * 3600 * GST_SECOND;
  const std::chrono::nanoseconds wait(std::min(max, kMax));
  return queue_.take(static_cast<int64_t>(time), wait, out);
}

}  // namespace weir
