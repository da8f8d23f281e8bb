// Reads the weights of a network that is written as plain float32 numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <cstddef>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "weir/engine.hpp"

namespace ars {

inline constexpr size_t kActivities = 5;
// The option of the filters below, as custom=weights:PATH.
inline constexpr const char* kWeightsOption =
    R"([{"name": "weights", "type": "string", "help": "file of the network's weights"}])";

// Reads the `count` numbers of the file that the option `weights` names. Throws weir::Failure when
// there is no such option or file, or when the file has another size or a number that is not
// finite.
inline std::vector<float> read_weights(const weir::Options& options, size_t count) {
  const auto path = options.get("weights");
  if (!path || path->empty())
    throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                         .what = "the filter has no weights",
                         .needed = "the file that tools/train/train_activities.py wrote",
                         .fix = "custom=weights:PATH"});
  std::ifstream file{std::string(*path), std::ios::binary | std::ios::ate};
  if (!file)
    throw weir::Failure({.code = weir::Code::MODEL_NOT_FOUND,
                         .what = "the weights cannot be read",
                         .offered = std::string(*path),
                         .needed = "a file that exists and may be read",
                         .fix = "custom=weights:PATH"});
  const auto bytes = static_cast<size_t>(file.tellg());
  std::vector<float> numbers(count);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(numbers.data()),
            static_cast<std::streamsize>(count * sizeof(float)));
  bool usable = file.good() && bytes == count * sizeof(float);
  for (const float number : numbers) usable = usable && std::isfinite(number);
  if (!usable)
    throw weir::Failure({.code = weir::Code::MODEL_INVALID,
                         .what = "the weights are not those of this network",
                         .offered = std::string(*path) + " of " + std::to_string(bytes) + " bytes",
                         .needed = std::to_string(count) + " finite float32 numbers, " +
                                   std::to_string(count * sizeof(float)) + " bytes",
                         .fix = "give the filter the file of its own network"});
  return numbers;
}

// Takes consecutive parts of the weights.
class Parts {
 public:
  explicit Parts(std::span<const float> numbers) : rest_(numbers) {}
  // Precondition: `count` numbers are left.
  std::span<const float> next(size_t count) {
    const auto part = rest_.first(count);
    rest_ = rest_.subspan(count);
    return part;
  }

 private:
  std::span<const float> rest_;
};

// Computes probabilities of a fully connected layer: weights [inputs, activities], then the bias.
inline void classify(std::span<const float> features, std::span<const float> weights,
                     std::span<const float> bias, std::span<float> probabilities) {
  float largest = -INFINITY, sum = 0;
  for (size_t k = 0; k < kActivities; ++k) {
    probabilities[k] = bias[k];
    for (size_t i = 0; i < features.size(); ++i)
      probabilities[k] += features[i] * weights[i * kActivities + k];
    largest = std::fmax(largest, probabilities[k]);
  }
  for (float& value : probabilities) sum += value = std::exp(value - largest);
  for (float& value : probabilities) value /= sum;
}

}  // namespace ars
