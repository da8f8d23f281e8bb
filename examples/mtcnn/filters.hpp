// The stages of the cascade as filters of a pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "cascade.hpp"
#include "stage_times.hpp"
#include "weir/custom_filter.hpp"

namespace mtcnn {

struct Setup {
  Size picture;
  std::vector<Size> layers;
  bool turned = false;  // networks take pictures with rows and columns exchanged
};

// Each filter reports a finished picture to `times`, which is borrowed.

// Converts P-Net's maps of all layers, two tensors each, to R-Net's regions: float32 4:N, x, y,
// width and height. Without candidates it outputs one region of one pixel, in which no network
// finds a face, so that each picture passes all stages.
weir::RegisteredFilter proposals(const Setup& setup, StageTimes* times);
// Converts R-Net's two tensors to O-Net's regions in the same way. The frame's source maps give the
// regions that R-Net processed.
weir::RegisteredFilter refinement(const Setup& setup, StageTimes* times);
// Converts O-Net's three tensors to rows of weir/detection.hpp with five key points.
weir::RegisteredFilter landmarks(StageTimes* times);

}  // namespace mtcnn
