// Reads boxes from tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/regions_pad.hpp"

namespace weir {

using preprocess::Box;

void RegionsPad::start() {
  queue_.clear();
  queue_.flush(false);
}

// Pictures are not flushed with it; they continue without boxes.
void RegionsPad::flush(bool on) {
  on ? queue_.end() : queue_.clear();
}

Status RegionsPad::accept(const FrameSpec& spec) {
  if (spec.format != Format::Static) return ok();
  if (spec.tensors.size() != 1)
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the stream of regions is not of boxes",
        .offered = spec.to_string(),
        .needed = "one tensor uint32 4:N or float32 4:N: x, y, width and height of each box",
        .difference = "number of tensors"};
  return preprocess::check_boxes(spec.tensors[0]);
}

// A frame without tensors has no boxes. Boxes without a time match no picture; before the first
// picture they count as unused.
Status RegionsPad::push(GstBuffer*, const std::vector<gst::TensorView>& tensors, int64_t time) {
  std::vector<Box> boxes;
  if (tensors.size() > 1) return preprocess::check_boxes(TensorSpec{});
  if (!tensors.empty()) {
    if (auto status = preprocess::check_boxes(tensors[0].spec); !status) return status;
    preprocess::read_boxes(tensors[0].spec, tensors[0].payload, &boxes);
  }
  queue_.push(time, std::move(boxes));
  return ok();
}

sync::TimedOutcome RegionsPad::take(GstClockTime time, GstClockTime most, std::vector<Box>* out) {
  constexpr GstClockTime kMost = 24 * 3600 * GST_SECOND;
  const std::chrono::nanoseconds wait(std::min(most, kMost));
  return queue_.take(static_cast<int64_t>(time), wait, out);
}

}  // namespace weir
