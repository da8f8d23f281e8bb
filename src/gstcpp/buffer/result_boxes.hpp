// ResultBoxes: reads the boxes of a stream of results (weir/results.h).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/preprocess/boxes.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/buffer/frame_layout.hpp"

namespace weir::gst {

class ResultBoxes {
 public:
  // Reads the columns of a stream whose spec has roles. SPEC_MISMATCH: they cannot be read, have no
  // boxes, or do not fit the tensors.
  static Result<ResultBoxes> parse(const FrameSpec& spec);
  // Appends the boxes of all rows that are not background. SPEC_MISMATCH: check_result_rows().
  Status read(const std::vector<TensorPlace>& tensors,
              std::vector<preprocess::PictureBox>* boxes) const;

 private:
  std::vector<weir_result_columns> columns_;  // one for each tensor
};

}  // namespace weir::gst
