// TorchWork: what a TorchScript model computes for inputs of given shapes, without running it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "thread_rule.hpp"
#include "weir/abi.h"

namespace weir::engine {

// The operators of a graph as far as they decide how many numbers there are. A value is known by
// how many numbers it has and how many channels; values are numbered in the order of their making,
// the inputs of the graph first.
class TorchWork {
 public:
  struct Step {
    std::vector<uint32_t> from;  // values
    double growth = 1;           // numbers out for each number in
    double positions = 0;        // numbers of each channel of a picture, where the step fixes them
    double channels = 0;         // of the result; 0 = as the first input
    double multiplications = 0;  // for each number out
    double weights = 0;          // that the step reads
    bool joins = false;          // concatenation: numbers and channels of all inputs add up
  };

  void set_inputs(size_t count) { inputs_ = count; }
  // The number of the value that the step makes.
  uint32_t add(Step step) {
    steps_.push_back(std::move(step));
    return static_cast<uint32_t>(inputs_ + steps_.size() - 1);
  }
  // Shapes that are not fixed are an unknown work.
  Work estimate(std::span<const weir_tensor_info> inputs) const;

 private:
  size_t inputs_ = 0;
  std::vector<Step> steps_;
};

}  // namespace weir::engine
