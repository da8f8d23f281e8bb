// The parts of the cascade for the nodes. ROS 1's headers do not compile as C++20, so this header
// is C++17: boxes are consecutive numbers, as in the messages. Errors are exceptions of Ort and cv.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace control {

// x1, y1, x2, y2 per region; x1, y1, x2, y2, score, five times x, y per face.
using Numbers = std::vector<float>;

// A network with its pre- and postprocessing. Not thread-safe.
class Part {
 public:
  virtual ~Part() = default;
  // Returns the remaining `regions` of an 8-bit R'G'B' picture; P-Net ignores them.
  virtual Numbers find(const cv::Mat& picture, const Numbers& regions) = 0;
};
std::unique_ptr<Part> p_part(const std::string& models, uint32_t min_face);
std::unique_ptr<Part> r_part(const std::string& models);
std::unique_ptr<Part> o_part(const std::string& models);

std::string to_json(const Numbers& faces);

// The times of each picture, in the format of ../../stage_times.hpp.
class Times {
 public:
  Times();
  ~Times();
  // Times in nanoseconds of the monotonic clock.
  void picture(int64_t begin, int64_t proposed, int64_t refined, int64_t marked);
  void copied(uint64_t bytes);
  bool write(const std::string& file);  // false on failure, with a line on stderr

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace control
