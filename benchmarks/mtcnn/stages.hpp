// The three stages of the cascade with OpenCV and ONNX Runtime, for the control and its ROS nodes.
// Pictures are 8-bit R'G'B'. Not thread-safe; errors are exceptions of Ort and cv.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <opencv2/core.hpp>

#include "cascade.hpp"
#include "network.hpp"

namespace control {

// A network's input; its memory is reused for each picture.
class Input {
 public:
  // Resizes `picture`, of any size, to `side` as number `index` of a batch of `count`.
  void take(const cv::Mat& picture, size_t index, size_t count, cv::Size side);
  std::span<float> numbers() { return numbers_; }
  const Shape& shape() const { return shape_; }
  // Bytes that were copied only to split colours into planes.
  uint64_t copied() const { return copied_; }
  // From now on take() also appends its bytes, before normalisation, to `bytes`; null: nowhere.
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
