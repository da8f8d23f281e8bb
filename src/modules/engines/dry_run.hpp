// DryRunInputs: zeros as inputs of a run that only finds out the outputs' shapes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// The bytes of all inputs together. Caps decide their sizes before any buffer came, so they must
// not decide how much memory is used.
inline constexpr uint64_t kDryRunBytes = uint64_t{1} << 30;

// SPEC_MISMATCH when a shape is open or has no size; LIMIT_EXCEEDED beyond kDryRunBytes.
Status check_dry_run(std::span<const weir_tensor_info> inputs);

class DryRunInputs {
 public:
  // Zeros in these shapes, in pages that are not backed until they are written. The errors of
  // check_dry_run(), or OUT_OF_MEMORY.
  static Result<DryRunInputs> create(std::span<const weir_tensor_info> infos);

  // They point into this object.
  std::span<weir_tensor> tensors() noexcept { return tensors_; }

 private:
  struct Free {
    void operator()(void* memory) const noexcept { std::free(memory); }
  };
  std::vector<std::unique_ptr<void, Free>> memory_;
  std::vector<weir_tensor> tensors_;
};

}  // namespace weir::engine
