// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/medium.hpp"

#include "core/convert/stacked_tensor.hpp"
#include "core/tensor/placeholder.hpp"

namespace weir {

Fraction get_rate(const GstCaps* caps) {
  Fraction rate;
  const GstStructure* s = gst_caps_get_structure(caps, 0);
  const bool there = gst_structure_get_fraction(s, "framerate", &rate.numerator, &rate.denominator);
  return there && rate.valid() ? rate : Fraction{0, 1};
}

void plan_before_the_first(const Preferences& preferences, StreamPlan* plan) {
  const auto& known = preferences.tensors.empty() ? preferences.peer : preferences.tensors;
  plan->first_frame_decides = known.empty();
  plan->spec.tensors = known;
  if (known.empty()) plan->spec.tensors = {placeholder()};
}

Status one_frame_each(const Preferences& preferences, const char* what) {
  if (preferences.frames_per_tensor == 1) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = std::string(what) + " cannot be combined into one output",
               .offered = "frames-per-tensor=" + std::to_string(preferences.frames_per_tensor),
               .needed = "frames-per-tensor=1",
               .fix = "tensor_converter frames-per-tensor=1"};
}

Status gather(uint32_t frames_per_tensor, std::vector<TensorSpec>* tensors) {
  if (frames_per_tensor == 1 || tensors->empty()) return ok();
  if (tensors->size() > 1)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "frames with several tensors cannot be combined into one output",
                 .offered = std::to_string(tensors->size()) +
                            " tensors, frames-per-tensor=" + std::to_string(frames_per_tensor),
                 .needed = "one tensor, or frames-per-tensor=1",
                 .fix = "tensor_converter frames-per-tensor=1"};
  auto all = stacked_tensor(tensors->front(), frames_per_tensor);
  if (!all) return all.error();
  tensors->front() = *std::move(all);
  return ok();
}

Status agree(const FrameSpec& given, const std::vector<TensorSpec>& user, const char* medium) {
  if (user.empty()) return ok();
  const std::string difference = first_difference(given.tensors, user);
  if (difference.empty()) return ok();
  FrameSpec needed = given;
  needed.tensors = user;
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string("the ") + medium + " does not match input-dim and input-type",
               .offered = given.to_string(),
               .needed = needed.to_string(),
               .difference = difference,
               .fix = "remove input-dim and input-type: the caps define the tensor"};
}

Status agree(const std::vector<TensorSpec>& frame, const std::vector<TensorSpec>& user) {
  const std::string difference = user.empty() ? "" : first_difference(frame, user);
  if (difference.empty()) return ok();
  FrameSpec offered{Format::Static, frame, {}}, needed{Format::Static, user, {}};
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "a frame does not match input-dim and input-type",
               .offered = offered.to_string(),
               .needed = needed.to_string(),
               .difference = difference,
               .fix = "remove input-dim and input-type: each frame describes its tensors"};
}

Status whole_frames(const GstBuffer* buffer, const StreamPlan& plan, const std::string& fix) {
  const size_t size = gst_buffer_get_size(const_cast<GstBuffer*>(buffer));
  if (size % plan.frame_bytes == 0) return ok();
  return Error{.code = Code::FRAME_SIZE,
               .what = "a buffer does not hold whole frames",
               .offered = std::to_string(size) + " bytes",
               .needed = "a multiple of " + std::to_string(plan.frame_bytes) + " bytes for " +
                         plan.spec.to_string(),
               .fix = fix};
}

}  // namespace weir
