// Axis: for each target pixel along one axis, the source samples that make it and their weights.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

// The source interval [begin, begin + length), which may exceed the picture, is mapped onto
// `targets` pixels. Only the pixels from `first` on are computed.
struct AxisWhole {
  int64_t begin = 0;
  uint32_t length = 0, targets = 0, first = 0;
  bool operator==(const AxisWhole&) const = default;
};
// The part [begin, begin + length) of the picture, in pixels, and the number of target pixels. The
// part covers all of them; with `whole`, it is the visible part of that larger interval.
struct AxisPart {
  uint32_t begin = 0, length = 0, targets = 0;
  std::optional<AxisWhole> whole = std::nullopt;
};

// How the samples of a plane are placed along the axis.
struct Sampling {
  bool halved = false;   // one sample for every two pixels
  bool cosited = false;  // at the centre of the even pixel instead of between the two
};

class Axis {
 public:
  Axis() = default;
  Axis(Resize resize, const AxisPart& part, Sampling sampling) { lay(resize, part, sampling); }

  // The formulas are in preparation.hpp. Precondition: length and targets are above 0. Keeps the
  // allocated memory.
  void lay(Resize resize, const AxisPart& part, Sampling sampling);

  size_t targets() const noexcept { return entries_.size(); }
  uint32_t first(size_t target) const noexcept { return entries_[target].first; }
  // The weights of the samples from first() on. At least one weight; they sum to 1.
  std::span<const float> weights(size_t target) const noexcept {
    return {weights_.data() + entries_[target].weights, entries_[target].count};
  }
  size_t max_weights() const noexcept { return max_weights_; }
  // The samples used are low() to high() - 1.
  uint32_t low() const noexcept { return low_; }
  uint32_t high() const noexcept { return high_; }

 private:
  struct Entry {
    uint32_t first, count;
    size_t weights;
  };
  void add(uint32_t first, std::span<const double> weights);
  void add_nearest(const AxisPart& part, int64_t pixel, Sampling sampling);
  void add_bilinear(double position);
  void add_area(double begin, double end);

  std::vector<Entry> entries_;
  std::vector<float> weights_;
  std::vector<double> area_weights_;  // scratch: the weights of the target pixel being added
  size_t max_weights_ = 0;
  uint32_t low_ = 0, high_ = 0;
};

}  // namespace weir::preprocess
