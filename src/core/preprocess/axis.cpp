// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace weir::preprocess {

void Axis::lay(Resize resize, const AxisPart& part, Sampling sampling) {
  entries_.clear();
  weights_.clear();
  max_weights_ = 0;
  const uint32_t pixels = sampling.halved ? 2 : 1;
  low_ = part.begin / pixels;
  high_ = (part.begin + part.length + pixels - 1) / pixels;
  const double shift = sampling.halved && sampling.cosited ? 0.25 : 0;
  const auto sample = [&](double pixel) { return pixel / pixels + shift; };
  const AxisWhole whole = part.whole.value_or(AxisWhole{part.begin, part.length, part.targets, 0});
  const auto begin = static_cast<double>(whole.begin);
  const double step = static_cast<double>(whole.length) / whole.targets;
  entries_.reserve(part.targets);
  for (uint32_t t = whole.first; t < whole.first + part.targets; ++t) {
    if (resize == Resize::Nearest)
      add_nearest(part, whole.begin + int64_t{t} * whole.length / whole.targets, sampling);
    else if (resize == Resize::Area && step / pixels > 1)
      add_area(sample(begin + t * step), sample(begin + (t + 1) * step));
    else
      add_bilinear(sample(begin + (t + 0.5) * step) - 0.5);
  }
}

void Axis::add(uint32_t first, std::span<const double> weights) {
  entries_.push_back({first, static_cast<uint32_t>(weights.size()), weights_.size()});
  for (const double weight : weights) weights_.push_back(static_cast<float>(weight));
  max_weights_ = std::max(max_weights_, weights.size());
}

void Axis::add_nearest(const AxisPart& part, int64_t pixel, Sampling sampling) {
  const int64_t last = int64_t{part.begin} + part.length - 1;
  const auto inside = static_cast<uint32_t>(std::clamp<int64_t>(pixel, part.begin, last));
  add(sampling.halved ? inside / 2 : inside, std::array{1.0});
}

void Axis::add_bilinear(double position) {
  // The position is above -1. The conversion is one instruction where std::floor may be a call.
  const double floor = static_cast<double>(static_cast<int64_t>(position + 1) - 1);
  const double fraction = position - floor;
  if (floor < low_)
    add(low_, std::array{1.0});
  else if (floor + 1 >= high_)
    add(high_ - 1, std::array{1.0});
  else if (fraction == 0)
    add(static_cast<uint32_t>(floor), std::array{1.0});
  else
    add(static_cast<uint32_t>(floor), std::array{1 - fraction, fraction});
}

void Axis::add_area(double begin, double end) {
  begin = std::max(begin, static_cast<double>(low_));
  end = std::min(end, static_cast<double>(high_));
  // Absorbs the rounding error of whole numbers; otherwise a target pixel would include a sliver of
  // the next sample.
  constexpr double kSliver = 1e-6;
  const auto first = static_cast<uint32_t>(std::min(std::floor(begin + kSliver), high_ - 1.0));
  area_weights_.clear();
  for (uint32_t i = first; i < high_ && (area_weights_.empty() || i < end - kSliver); ++i)
    area_weights_.push_back(
        std::max(0.0, std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i))));
  const double sum = std::accumulate(area_weights_.begin(), area_weights_.end(), 0.0);
  for (double& weight : area_weights_) weight /= sum;
  add(first, area_weights_);
}

}  // namespace weir::preprocess
