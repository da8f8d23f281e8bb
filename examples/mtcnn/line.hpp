// Builds the pipeline as text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "filters.hpp"

namespace mtcnn {

// The files and the input format of the three networks.
struct Networks {
  std::string framework;  // of tensor_filter
  std::string files[3];   // model= of P-Net, R-Net, O-Net
  bool turned = false;    // rows and columns of the picture are exchanged
  bool planes = true;     // colours are planes (NCHW); otherwise interleaved (NHWC)
  bool bytes = false;     // takes unnormalised bytes
  bool rounded = false;   // crops and resized pictures are rounded to bytes nevertheless
  bool fixed = false;  // sizes in the file must be replaced by input=, and the batch size is fixed
  std::string custom;  // custom= of each network, may be empty; follows what the format needs
};
// Finds the files for a framework in a subfolder of `folder` (onnx, onnx_nhwc, torchscript, caffe
// or tflite). FILE_NOT_FOUND lists the folders searched.
weir::Result<Networks> find_networks(const std::string& framework, const std::string& folder);

// Returns elements from `pictures`, a tee of raw video, to a last element with an unlinked source
// pad: rows of weir/detection.hpp.
std::string networks_line(const Setup& setup, const Networks& networks, std::string_view pictures);

}  // namespace mtcnn
