// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/regions_pad.hpp"

#include <algorithm>

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
  columns_.clear();
  if (!spec.roles.empty()) return accept_results(spec);
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

Status RegionsPad::accept_results(const FrameSpec& spec) {
  std::vector<weir_result_columns> columns;
  bool has_boxes = false;
  for (const ResultRole& role : spec.roles) {
    columns.emplace_back();
    if (!weir_results_parse(role.columns.c_str(), 0, &columns.back()))
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the columns of a stream of results cannot be read",
                   .offered = "weir-columns=\"" + columns_text(spec.roles) + "\"",
                   .needed = "columns as in weir/results.h",
                   .difference = "at \"" + role.columns + "\""};
    has_boxes = has_boxes || columns.back().box >= 0;
    const size_t tensor = columns.size() - 1;
    if (columns.back().kind == WEIR_RESULT_ROWS && tensor < spec.tensors.size())
      if (auto status = preprocess::check_result_rows(spec.tensors[tensor], columns.back());
          !status)
        return status;
  }
  if (!has_boxes)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the stream of regions has results without boxes",
                 .offered = "weir-columns=\"" + columns_text(spec.roles) + "\"",
                 .needed = "the columns x1,y1,x2,y2",
                 .fix = "tensor_decoder mode=detection"};
  columns_ = std::move(columns);
  return ok();
}

Status RegionsPad::read_results(const std::vector<gst::TensorPlace>& tensors,
                                std::vector<preprocess::Roi>* boxes) const {
  uint64_t row = 0;
  for (size_t i = 0; i < std::min(tensors.size(), columns_.size()); ++i) {
    if (columns_[i].kind != WEIR_RESULT_ROWS) continue;
    if (auto status = preprocess::check_result_rows(tensors[i].spec, columns_[i]); !status)
      return status;
    preprocess::read_result_boxes(columns_[i], tensors[i].payload, row, boxes);
    row += tensors[i].payload.size() / (size_t{columns_[i].length} * sizeof(float));
  }
  return ok();
}

// A frame without tensors has no boxes. Boxes without a time match no picture; before the first
// picture they count as unused.
Status RegionsPad::push(GstBuffer*, const std::vector<gst::TensorPlace>& tensors, int64_t time) {
  std::vector<preprocess::Roi> boxes;
  if (!columns_.empty()) {
    if (auto status = read_results(tensors, &boxes); !status) return status;
    queue_.push(time, std::move(boxes));
    return ok();
  }
  if (tensors.size() > 1) return preprocess::check_boxes(TensorSpec{});
  if (!tensors.empty()) {
    if (auto status = preprocess::check_boxes(tensors[0].spec); !status) return status;
    preprocess::read_boxes(tensors[0].spec, tensors[0].payload, &boxes);
  }
  queue_.push(time, std::move(boxes));
  return ok();
}

sync::TimedOutcome RegionsPad::take(GstClockTime time, GstClockTime max,
                                    std::vector<preprocess::Roi>* out) {
  constexpr GstClockTime kMax = GstClockTime{24} * 3600 * GST_SECOND;
  const std::chrono::nanoseconds wait(std::min(max, kMax));
  return queue_.take(static_cast<int64_t>(time), wait, out);
}

}  // namespace weir
