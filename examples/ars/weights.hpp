// Reads the weights of a network that are written as plain float32 or float16 numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

// A number of 16 bits (IEEE 754 binary16) as it is stored; the bits of a float have the same order.
struct Half {
  uint16_t bits;
  explicit operator float() const {
    if ((bits & 0x7C00U) == 0x7C00U) return NAN;  // infinite, or not a number
    const float size =
        std::bit_cast<float>((bits & 0x7FFFU) << 13U) * 0x1p112F;  // of the exponents
    return (bits & 0x8000U) != 0 ? -size : size;
  }
};

// Reads the `count` numbers of the file that the option `weights` names, stored as float32 or, with
// Half, as float16. Throws weir::Failure when there is no such option or file, or when the file has
// another size or a number that is not finite.
template <class Stored = float>
std::vector<float> read_weights(const weir::Options& options, size_t count) {
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
  const auto bytes = static_cast<size_t>(file.tellg()), needed = count * sizeof(Stored);
  std::vector<Stored> stored(count);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(stored.data()), static_cast<std::streamsize>(needed));
  bool usable = file.good() && bytes == needed;
  std::vector<float> numbers;
  numbers.reserve(count);
  for (const Stored& number : stored) {
    numbers.push_back(static_cast<float>(number));
    usable = usable && std::isfinite(numbers.back());
  }
  if (!usable)
    throw weir::Failure({.code = weir::Code::MODEL_INVALID,
                         .what = "the weights are not those of this network",
                         .offered = std::string(*path) + " of " + std::to_string(bytes) + " bytes",
                         .needed = std::to_string(count) + " finite float" +
                                   std::to_string(8 * sizeof(Stored)) + " numbers, " +
                                   std::to_string(needed) + " bytes",
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
