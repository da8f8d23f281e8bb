// Converts pictures and regions to a network's input, and its output to boxes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "stages.hpp"

#include <opencv2/imgproc.hpp>

namespace control {
namespace {

using mtcnn::Size;

std::span<const float> values(const Ort::Value& tensor) {
  return {tensor.GetTensorData<float>(), tensor.GetTensorTypeAndShapeInfo().GetElementCount()};
}

Size get_size(const cv::Mat& picture) {
  return {static_cast<uint32_t>(picture.cols), static_cast<uint32_t>(picture.rows)};
}

// Crops the regions into one batch; black outside the picture.
void cut(const cv::Mat& picture, std::span<const weir::Box> regions, uint32_t side, Input* input) {
  const cv::Rect all(0, 0, picture.cols, picture.rows);
  const int length = static_cast<int>(side);
  cv::Mat padded;
  for (size_t i = 0; i < regions.size(); ++i) {
    const weir::Box& box = regions[i];
    const cv::Rect whole(cv::Point(static_cast<int>(box.x1), static_cast<int>(box.y1)),
                         cv::Point(static_cast<int>(box.x2), static_cast<int>(box.y2)));
    const cv::Rect part = whole & all;
    if (part == whole) {
      input->take(picture(part), i, regions.size(), {length, length});
      continue;
    }
    cv::copyMakeBorder(picture(part), padded, part.y - whole.y, whole.br().y - part.br().y,
                       part.x - whole.x, whole.br().x - part.br().x, cv::BORDER_CONSTANT);
    input->take(padded, i, regions.size(), {length, length});
  }
}

}  // namespace

void Input::take(const cv::Mat& picture, size_t index, size_t count, cv::Size side) {
  const auto plane = static_cast<size_t>(side.area());
  numbers_.resize(3 * plane * count);
  shape_ = {static_cast<int64_t>(count), 3, side.height, side.width};
  cv::resize(picture, resized_, side, 0, 0, cv::INTER_LINEAR);
  if (kept_) kept_->insert(kept_->end(), resized_.datastart, resized_.dataend);
  resized_.convertTo(apart_, CV_32F, 0.0078125, -127.5 * 0.0078125);
  cv::Mat planes[3];
  float* out = numbers_.data() + 3 * plane * index;
  for (size_t c = 0; c < 3; ++c)
    planes[c] = cv::Mat(side.height, side.width, CV_32F, out + c * plane);
  cv::split(apart_, planes);
  copied_ += 3 * plane * sizeof(float);
}

std::vector<weir::Box> Propose::find(const cv::Mat& picture) {
  const Size size = get_size(picture);
  std::vector<mtcnn::Candidate> all;
  for (const Size& layer : mtcnn::pyramid(size, min_face_)) {
    input_.take(picture, 0, 1, {static_cast<int>(layer.width), static_cast<int>(layer.height)});
    const auto out = network_.run(input_.numbers(), input_.shape());
    const auto shape = out[0].GetTensorTypeAndShapeInfo().GetShape();
    const auto rows = static_cast<size_t>(shape[2]), columns = static_cast<size_t>(shape[3]);
    const mtcnn::Steps steps{1, columns, rows * columns};
    const auto found =
        mtcnn::propose({{static_cast<uint32_t>(columns), static_cast<uint32_t>(rows)},
                        values(out[0]),
                        values(out[1]),
                        steps,
                        steps},
                       layer, size);
    all.insert(all.end(), found.begin(), found.end());
  }
  return mtcnn::join(std::move(all), size);
}

std::vector<weir::Box> Refine::find(const cv::Mat& picture, std::vector<weir::Box> regions) {
  if (regions.empty()) return {};
  cut(picture, regions, mtcnn::kRefineSide, &input_);
  const auto out = network_.run(input_.numbers(), input_.shape());
  return mtcnn::refine(regions, values(out[0]), values(out[1]), get_size(picture));
}

std::vector<mtcnn::Face> Mark::find(const cv::Mat& picture, std::vector<weir::Box> regions) {
  if (regions.empty()) return {};
  cut(picture, regions, mtcnn::kLandmarkSide, &input_);
  const auto out = network_.run(input_.numbers(), input_.shape());
  return mtcnn::faces(regions, values(out[0]), values(out[1]), values(out[2]));
}

}  // namespace control
