// The cascade as filters of a pipeline.
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
  bool turned = false;  // the networks take the picture with rows and columns exchanged
};

// Each tells `times`, which is borrowed, when it is done with a picture.

// P-Net's maps of all layers, two tensors each, to R-Net's regions: float32 4:N, x, y, width and
// height. Where nothing is found it is one region of one pixel, in which no network sees a face: so
// each picture goes all the way.
weir::RegisteredFilter proposals(const Setup& setup, StageTimes* times);
// R-Net's two tensors to O-Net's regions, likewise. What it looked at says the frame: its way back.
weir::RegisteredFilter refinement(const Setup& setup, StageTimes* times);
// O-Net's three tensors to rows of weir/detection.hpp with five key points.
weir::RegisteredFilter landmarks(StageTimes* times);

}  // namespace mtcnn
