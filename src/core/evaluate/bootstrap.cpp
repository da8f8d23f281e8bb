// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/bootstrap.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace weir::evaluate {
namespace {

// Linear between the two nearest of the sorted values, as NumPy's default.
double quantile(const std::vector<double>& sorted, double part) {
  const double place = part * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

Interval compute_interval(std::vector<double> values) {
  constexpr double kTail = 0.025;
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {quantile(values, kTail), quantile(values, 1 - kTail)};
}

}  // namespace

std::vector<Interval> bootstrap(size_t units, size_t draws, uint64_t seed, const Measure& measure) {
  // std::uniform_int_distribution differs between standard libraries, the generator does not.
  std::mt19937_64 generator(seed);
  std::vector<std::vector<double>> values;
  std::vector<uint32_t> times(units);
  for (size_t draw = 0; draw < draws; ++draw) {
    std::fill(times.begin(), times.end(), 0);
    for (size_t i = 0; i < units; ++i) ++times[generator() % units];
    const auto numbers = measure(times);
    values.resize(numbers.size());
    for (size_t i = 0; i < numbers.size(); ++i) values[i].push_back(numbers[i]);
  }
  std::vector<Interval> out;
  out.reserve(values.size());
  for (auto& one : values) out.push_back(compute_interval(std::move(one)));
  return out;
}

}  // namespace weir::evaluate
