// SampleOrder: which sample is next, over a range and over passes (docs/compatibility/io.md 7.2).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "weir/result.hpp"

namespace weir::dataset {

struct OrderRequest {
  uint64_t start = 0, stop = 0;  // inclusive; a stop of 0 is the last sample
  uint32_t epochs = 1;           // passes
  bool is_shuffled = true;       // from the second pass on
  uint32_t seed = 0;             // of the order; 0: another one in each run
};

class SampleOrder {
 public:
  SampleOrder() = default;
  // OPTION_VALUE for a range that is not within `samples`, LIMIT_EXCEEDED for one that is too long
  // to be shuffled.
  static Result<SampleOrder> make(const OrderRequest& request, uint64_t samples);
  // Nullopt after the last pass.
  std::optional<uint64_t> next();

 private:
  void begin_pass();

  uint64_t first_ = 0, count_ = 0, at_ = 0;
  uint32_t passes_left_ = 0;  // with the current one
  bool is_shuffled_ = false;
  std::vector<uint32_t> shuffled_;  // distances from the first sample; empty in the first pass
  std::mt19937_64 random_;
};

}  // namespace weir::dataset
