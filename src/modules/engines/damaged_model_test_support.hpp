// Makes damaged versions of a model file, the same in every run: truncated or with flipped bits.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <random>

#include "engine_test_support.hpp"

namespace weir::engine_test {

inline constexpr int kDamagedVersions = 200;

// Every third version is truncated; the others have 1 to 8 flipped bits.
inline std::vector<std::byte> damaged(const std::vector<std::byte>& whole, int version) {
  std::mt19937 random(static_cast<uint32_t>(version));
  auto bytes = whole;
  if (version % 3 == 0) {
    bytes.resize(random() % whole.size());
    return bytes;
  }
  for (uint32_t bits = 1 + random() % 8; bits > 0; --bits) {
    const size_t bit = random() % (8 * whole.size());
    bytes[bit / 8] ^= std::byte{1} << bit % 8;
  }
  return bytes;
}

struct DamageCounts {
  int refused = 0, failed = 0, ran = 0, large = 0;
};

// Whether all inputs fit into `max` bytes, counting an open dimension as 1.
inline bool inputs_fit(const OpenEngine& model, double max) {
  double bytes = 0;
  for (const auto& info : model.inputs()) {
    double elements = 8;
    for (const int64_t extent : to_shape(info)) elements *= std::max(1.0, std::abs(double(extent)));
    bytes += elements;
  }
  return bytes <= max;
}

inline int64_t bytes_of_element(uint32_t type) {
  constexpr int64_t kBytes[WEIR_TYPE_END] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
  return type < WEIR_TYPE_END ? kBytes[type] : 0;
}

// Opens each version and runs it once on zeros. Each must be rejected with an error, fail with an
// error, or return outputs of the declared sizes.
inline DamageCounts run_damaged(const weir_engine& engine, const std::vector<std::byte>& whole,
                                const TemporaryFolder& folder,
                                const OpenEngine::Options& options = {}) {
  constexpr double kMax = 64e6;  // bytes; larger models are not run
  DamageCounts counts;
  for (int version = 0; version < kDamagedVersions; ++version) {
    const auto path = folder.write("damaged.bin", damaged(whole, version));
    const auto model = OpenEngine::open(engine, path, options);
    if (!model) {
      ++counts.refused;
      EXPECT_FALSE(model.error().what.empty()) << version;
      continue;
    }
    if (!inputs_fit(**model, kMax)) {
      ++counts.large;
      continue;
    }
    const auto outputs = (*model)->invoke(zero_inputs(**model));
    if (!outputs) {
      ++counts.failed;
      EXPECT_FALSE(outputs.error().what.empty()) << version;
      continue;
    }
    ++counts.ran;
    for (const auto& output : *outputs) {
      int64_t elements = 1;
      for (const int64_t extent : to_shape(output.info)) {
        EXPECT_GE(extent, 0) << version;
        elements *= extent;
      }
      EXPECT_EQ(elements * bytes_of_element(output.info.type),
                static_cast<int64_t>(output.bytes.size()))
          << version;
    }
  }
  return counts;
}

}  // namespace weir::engine_test
