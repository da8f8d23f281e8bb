// TorchWork: estimates the work of a TorchScript model for given input shapes without running it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "thread_rule.hpp"
#include "weir/abi.h"

namespace weir::engine {

// The operators of a graph that determine how many elements values have. A value is represented by
// its number of elements and channels; values are numbered in order of creation, starting with the
// graph's inputs.
class TorchWork {
 public:
  struct Step {
    std::vector<uint32_t> from;  // value numbers
    double growth = 1;           // output elements per input element
    double positions = 0;        // elements per channel of a picture, if the step sets them
    double channels = 0;         // of the result; 0 = as the first input
    double multiplications = 0;  // per output element
    double weights = 0;          // read by the step
    bool joins = false;          // concatenation: adds the elements and channels of all inputs
  };

  void set_inputs(size_t count) { inputs_ = count; }
  // Returns the number of the value that the step produces.
  uint32_t add(Step step) {
    steps_.push_back(std::move(step));
    return static_cast<uint32_t>(inputs_ + steps_.size() - 1);
  }
  // Open shapes give unknown work.
  Work estimate(std::span<const weir_tensor_info> inputs) const;

 private:
  size_t inputs_ = 0;
  std::vector<Step> steps_;
};

}  // namespace weir::engine
