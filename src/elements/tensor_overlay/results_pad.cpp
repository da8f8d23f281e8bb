// Reads detection results from tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/results_pad.hpp"

#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {

void ResultsPad::start(ResultsSync sync, Coordinates coordinates) {
  sync_ = sync;
  coordinates_ = coordinates;
  newest_.reset();
  queue_.clear();
  queue_.flush(false);
  unused_before_ = queue_.unused();
  for (auto* count : {&received_, &refused_, &found_, &late_, &background_, &not_finite_,
                      &without_area_, &beyond_limit_, &points_not_finite_})
    *count = 0;
}

// Pictures continue without results meanwhile.
void ResultsPad::flush(bool on) {
  if (on) {
    queue_.end();
    return;
  }
  newest_.clear();
  queue_.clear();
}

void ResultsPad::flush_pictures(bool on) {
  queue_.flush(on);
  if (!on) newest_.clear();
}

Status ResultsPad::accept(const FrameSpec& spec) {
  if (spec.format != Format::Static) return ok();
  if (spec.tensors.size() == 1) return draw::check_detections(spec.tensors[0]);
  return draw::check_detections(TensorSpec{});
}

Status ResultsPad::receive_counted(GstBuffer* buffer) {
  ++received_;
  Status status = receive(buffer);
  if (!status) ++refused_;
  return status;
}

// A frame without tensors has no results.
Status ResultsPad::push(GstBuffer* buffer, const std::vector<gst::TensorView>& tensors,
                        int64_t time) {
  Result<Results> results = std::make_shared<const draw::Detections>();
  if (tensors.size() > 1) return draw::check_detections(TensorSpec{});
  if (tensors.size() == 1) results = read(buffer, tensors[0]);
  if (!results) return results.error();
  count((*results)->left_out);
  if (sync_ == ResultsSync::Newest)
    newest_.push(time, *std::move(results));
  else
    queue_.push(time, *std::move(results));
  return ok();
}

Result<ResultsPad::Results> ResultsPad::read(GstBuffer* buffer, const gst::TensorView& tensor) {
  if (auto status = draw::check_detections(tensor.spec); !status) return status.error();
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
  auto detections = draw::read_detections(tensor.spec, tensor.payload, maps);
  if (!detections) return detections.error();
  return Results(std::make_shared<const draw::Detections>(*std::move(detections)));
}

void ResultsPad::count(const draw::LeftOut& left_out) {
  background_ += left_out.background;
  not_finite_ += left_out.not_finite;
  without_area_ += left_out.without_area;
  beyond_limit_ += left_out.beyond_limit;
  points_not_finite_ += left_out.points_not_finite;
}

bool ResultsPad::take(int64_t time, const Limits& limits, Results* out) {
  if (sync_ == ResultsSync::Newest) {
    *out = newest_.at(time, limits.max_age);
    return true;
  }
  out->reset();
  if (time == sync::kNoTime) return true;
  using Outcome = sync::TimedOutcome;
  const std::chrono::nanoseconds wait(static_cast<int64_t>(limits.max_wait));
  const Outcome outcome = queue_.take(time, wait, out);
  found_ += outcome == Outcome::Found;
  late_ += outcome == Outcome::Late;
  return outcome != Outcome::Flushed;
}

void ResultsPad::add_stats(GstStructure* stats) const {
  const auto newest = newest_.counts();
  const auto add = [stats](const char* name, uint64_t value) {
    gst_structure_set(stats, name, G_TYPE_UINT64, value, nullptr);
  };
  add("results-received", received_);
  add("results-drawn", newest.used + found_);
  add("results-replaced", newest.replaced);
  add("results-flushed", newest.cleared);
  add("results-unused", queue_.unused() - unused_before_);
  add("results-refused", refused_);
  add("results-held", newest.waiting + queue_.waiting());
  add("results-late", late_);
  add("rows-background", background_);
  add("rows-not-finite", not_finite_);
  add("rows-without-area", without_area_);
  add("rows-beyond-limit", beyond_limit_);
  add("points-not-finite", points_not_finite_);
}

}  // namespace weir
