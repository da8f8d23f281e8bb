// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/result_boxes.hpp"

#include <algorithm>

#include "core/tensor/result_roles.hpp"

namespace weir::gst {

Result<ResultBoxes> ResultBoxes::parse(const FrameSpec& spec) {
  ResultBoxes out;
  bool has_boxes = false;
  for (const ResultRole& role : spec.roles) {
    const size_t tensor = out.columns_.size();
    weir_result_columns& columns = out.columns_.emplace_back();
    if (!weir_results_parse(role.columns.c_str(), 0, &columns))
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the columns of a stream of results cannot be read",
                   .offered = "weir-columns=\"" + columns_text(spec.roles) + "\"",
                   .needed = "columns as in weir/results.h",
                   .difference = "at \"" + role.columns + "\""};
    has_boxes = has_boxes || columns.box >= 0;
    if (columns.kind == WEIR_RESULT_ROWS && tensor < spec.tensors.size())
      if (auto status = preprocess::check_result_rows(spec.tensors[tensor], columns); !status)
        return status.error();
  }
  if (!has_boxes)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the stream of regions has results without boxes",
                 .offered = "weir-columns=\"" + columns_text(spec.roles) + "\"",
                 .needed = "the columns x1,y1,x2,y2",
                 .fix = "tensor_decoder mode=detection"};
  return out;
}

Status ResultBoxes::read(const std::vector<TensorPlace>& tensors,
                         std::vector<preprocess::PictureBox>* boxes) const {
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

}  // namespace weir::gst
