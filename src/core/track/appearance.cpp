// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/appearance.hpp"

#include <cmath>
#include <numeric>

namespace weir::track {
namespace {

constexpr float kKept = 0.9f, kUnknown = 2;

// 0 for a vector without a direction.
float compute_norm(std::span<const float> vector) {
  const double square = std::inner_product(
      vector.begin(), vector.end(), vector.begin(), 0.0, [](double a, double b) { return a + b; },
      [](float a, float b) { return double{a} * b; });
  const double length = std::sqrt(square);
  return std::isfinite(length) && length < 1e18 && length > 1e-18 ? static_cast<float>(length) : 0;
}

}  // namespace

void Appearance::add(std::span<const float> vector) {
  const float length = compute_norm(vector);
  if (length == 0 || (!mean_.empty() && mean_.size() != vector.size())) return;
  const float kept = mean_.empty() ? 0 : kKept;
  mean_.resize(vector.size());
  for (size_t i = 0; i < vector.size(); ++i)
    mean_[i] = kept * mean_[i] + (1 - kept) * vector[i] / length;
  const float all = compute_norm(mean_);
  if (all == 0) return mean_.clear();
  for (float& number : mean_) number /= all;
}

float Appearance::distance(std::span<const float> vector) const noexcept {
  if (mean_.empty() || mean_.size() != vector.size()) return kUnknown;
  const float length = compute_norm(vector);
  if (length == 0) return kUnknown;
  return 1 - std::inner_product(mean_.begin(), mean_.end(), vector.begin(), 0.0f) / length;
}

}  // namespace weir::track
