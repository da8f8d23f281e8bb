// Prepares pictures for YOLOX and decodes its output: one row of box, objectness and class scores
// for each cell of three grids.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detector.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace street {
namespace {

constexpr int kSide = 416;        // pixels of the network's square input
constexpr double kPadding = 114;  // gray around the letterboxed picture
constexpr int kRowsOfHd = 720;
constexpr int kStrides[] = {8, 16, 32};
constexpr float kMaxOverlap = 0.45f;
constexpr int kMaxObjects = 100;

struct Candidates {
  std::vector<cv::Rect2d> boxes;  // pixels of the network's input
  std::vector<float> scores;
};

Candidates decode(const cv::Mat& rows, int class_index, float threshold) {
  Candidates out;
  int row = 0;
  for (const int stride : kStrides)
    for (int y = 0; y < kSide / stride; ++y)
      for (int x = 0; x < kSide / stride; ++x, ++row) {
        const auto* values = rows.ptr<float>(row);
        const float *first = values + 5, *end = values + rows.cols;
        const auto* best = std::max_element(first, end);
        const float score = values[4] * *best;
        if (best - first != class_index || score < threshold) continue;
        const double width = std::exp(double{values[2]}) * stride;
        const double height = std::exp(double{values[3]}) * stride;
        out.boxes.emplace_back((double{values[0]} + x) * stride - width / 2,
                               (double{values[1]} + y) * stride - height / 2, width, height);
        out.scores.push_back(score);
      }
  return out;
}

// VideoCapture converts every clip by BT.601; from 720 rows on, clips that say nothing are BT.709.
// For a BGR picture: from R, G, B to Y, B - Y and R - Y of BT.601, then by BT.709 to R, G, B.
cv::Matx33f to_bt709() {
  const cv::Matx33f luma(0.114f, 0.587f, 0.299f, 0.114f, 0.587f, 0.299f, 0.114f, 0.587f, 0.299f);
  const float blue = 1 / 1.772f, red = 1 / 1.402f;
  const cv::Matx33f of_differences(1.8556f * blue, 0, 0, -0.1873f * blue, 0, -0.4681f * red, 0, 0,
                                   1.5748f * red);
  return luma + of_differences * (cv::Matx33f::eye() - luma);
}

}  // namespace

const cv::Mat& Detector::letterboxed(const cv::Mat& picture) {
  const double scale = std::min(static_cast<double>(kSide) / picture.cols,
                                static_cast<double>(kSide) / picture.rows);
  content_.width = static_cast<int>(std::lround(picture.cols * scale));
  content_.height = static_cast<int>(std::lround(picture.rows * scale));
  content_.x = (kSide - content_.width) / 2;
  content_.y = (kSide - content_.height) / 2;
  input_.create(kSide, kSide, CV_8UC3);
  input_.setTo(cv::Scalar::all(kPadding));
  cv::resize(picture, resized_, content_.size(), 0, 0, cv::INTER_LINEAR);
  if (picture.rows >= kRowsOfHd) cv::transform(resized_, resized_, to_bt709());
  resized_.copyTo(input_(content_));
  return input_;
}

std::vector<Detection> Detector::find(const cv::Mat& picture, int class_index, float threshold,
                                      std::istream* inputs) {
  cv::dnn::blobFromImage(letterboxed(picture), blob_);
  if (inputs && !inputs->read(reinterpret_cast<char*>(blob_.data),
                              static_cast<std::streamsize>(blob_.total() * blob_.elemSize())))
    return {};
  network_.setInput(blob_);
  const cv::Mat output = network_.forward();  // 1, cells, values
  const Candidates found = decode(output.reshape(1, output.size[1]), class_index, threshold);
  std::vector<int> kept;
  cv::dnn::NMSBoxes(found.boxes, found.scores, threshold, kMaxOverlap, kept, 1, kMaxObjects);
  const double to_x = static_cast<double>(picture.cols) / content_.width;
  const double to_y = static_cast<double>(picture.rows) / content_.height;
  std::vector<Detection> objects;
  for (const int i : kept) {
    const cv::Rect2d& box = found.boxes[static_cast<size_t>(i)];
    objects.push_back({.box = {static_cast<float>((box.x - content_.x) * to_x),
                               static_cast<float>((box.y - content_.y) * to_y),
                               static_cast<float>((box.x + box.width - content_.x) * to_x),
                               static_cast<float>((box.y + box.height - content_.y) * to_y)},
                       .score = found.scores[static_cast<size_t>(i)],
                       .class_index = class_index});
  }
  return objects;
}

}  // namespace street
