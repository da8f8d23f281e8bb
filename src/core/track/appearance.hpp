// What an object looks like: the mean of the vectors that a network makes of its boxes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

namespace weir::track {

class Appearance {
 public:
  // 0.9 of the appearance so far and 0.1 of the vector, of unit length (BoT-SORT, arXiv 2206.14651,
  // equation 10). A vector of zeros, of numbers that are not finite or of another length is
  // ignored.
  void add(std::span<const float> vector);
  // 1 minus the cosine of the angle to a vector, 0 to 2; 2 where one of them is unknown.
  float distance(std::span<const float> vector) const noexcept;

 private:
  std::vector<float> mean_;
};

}  // namespace weir::track
