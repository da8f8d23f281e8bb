// The three parts of the cascade in OpenCV and ONNX Runtime, as the control and its ROS nodes use
// them. A picture is 8-bit R'G'B'. Not thread-safe; errors are exceptions of Ort and cv.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <opencv2/core.hpp>

#include "../cascade.hpp"
#include "network.hpp"

namespace control {

// The network's input, its memory kept from picture to picture.
class Input {
 public:
  // One of as many pictures of `side`; `picture` of any size.
  void take(const cv::Mat& picture, size_t index, size_t count, cv::Size side);
  std::span<float> numbers() { return numbers_; }
  const Shape& shape() const { return shape_; }
  // Bytes that were put into other memory a second time: colours that are set apart in planes.
  uint64_t copied() const { return copied_; }
  // What take() makes from now on goes there too, as bytes before they are numbers; null: nowhere.
  void keep(std::vector<uint8_t>* bytes) { kept_ = bytes; }

 private:
  cv::Mat resized_, apart_;
  std::vector<float> numbers_;
  Shape shape_{};
  uint64_t copied_ = 0;
  std::vector<uint8_t>* kept_ = nullptr;
};

class Propose {
 public:
  Propose(Ort::Env& env, const std::string& models, int threads, uint32_t min_face)
      : network_(p_net(env, models, threads)), min_face_(min_face) {}
  std::vector<weir::Box> find(const cv::Mat& picture);
  uint64_t copied() const { return input_.copied(); }
  void keep(std::vector<uint8_t>* bytes) { input_.keep(bytes); }

 private:
  Network network_;
  uint32_t min_face_;
  Input input_;
};

class Refine {
 public:
  Refine(Ort::Env& env, const std::string& models, int threads)
      : network_(r_net(env, models, threads)) {}
  std::vector<weir::Box> find(const cv::Mat& picture, std::vector<weir::Box> regions);
  uint64_t copied() const { return input_.copied(); }
  void keep(std::vector<uint8_t>* bytes) { input_.keep(bytes); }

 private:
  Network network_;
  Input input_;
};

class Mark {
 public:
  Mark(Ort::Env& env, const std::string& models, int threads)
      : network_(o_net(env, models, threads)) {}
  std::vector<mtcnn::Face> find(const cv::Mat& picture, std::vector<weir::Box> regions);
  uint64_t copied() const { return input_.copied(); }
  void keep(std::vector<uint8_t>* bytes) { input_.keep(bytes); }

 private:
  Network network_;
  Input input_;
};

}  // namespace control
