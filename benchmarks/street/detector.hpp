// Detector: finds objects in a picture with YOLOX (Ge et al., arXiv 2107.08430) and OpenCV's DNN
// module.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <istream>
#include <opencv2/dnn.hpp>
#include <string>
#include <vector>

#include "weir/detection.hpp"

namespace street {

struct Detection {
  weir::Box box;  // pixels of the picture
  float score = 0;
  int class_index = 0;
  uint32_t track = 0;  // 0 = none
};

class Detector {
 public:
  // Throws cv::Exception if OpenCV cannot read the model.
  explicit Detector(const std::string& model) : network_(cv::dnn::readNet(model)) {}

  // The objects of one class in a BGR picture, best first. With `inputs`, the network sees the next
  // input of that file instead of the picture; nothing if the file has ended.
  std::vector<Detection> find(const cv::Mat& picture, int class_index, float threshold,
                              std::istream* inputs);

 private:
  const cv::Mat& letterboxed(const cv::Mat& picture);

  cv::dnn::Net network_;
  cv::Mat resized_, input_, blob_;
  cv::Rect content_;  // of the picture in the network's input
};

}  // namespace street
