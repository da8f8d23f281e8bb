// The pipeline as text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "filters.hpp"

namespace mtcnn {

// The three networks' files and what they take.
struct Networks {
  std::string framework;  // of tensor_filter
  std::string files[3];   // model= of P-Net, R-Net, O-Net
  bool turned = false;    // rows and columns of the picture are exchanged
  bool planes = true;     // colours are planes (NCHW), or beside each other (NHWC)
  bool bytes = false;     // it takes the picture's bytes as they are
  bool rounded = false;   // what is cut and resized is rounded to bytes all the same
  bool fixed = false;     // the file says sizes that input= must replace, and a batch has one size
  std::string custom;     // custom= of each, may be empty; behind what the format needs
};
// The files in `folder` (onnx, onnx_nhwc, torchscript, caffe or tflite in it) for a framework.
// FILE_NOT_FOUND names what was looked for.
weir::Result<Networks> find_networks(const std::string& framework, const std::string& folder);

// Elements from `pictures`, a tee of raw video, to a last one whose source pad is free: rows of
// weir/detection.hpp.
std::string networks_line(const Setup& setup, const Networks& networks, std::string_view pictures);

}  // namespace mtcnn
