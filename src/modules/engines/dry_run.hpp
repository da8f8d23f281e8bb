// DryRunInputs: zero-filled inputs for a run whose only purpose is to find the outputs' shapes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// The limit for the bytes of all inputs. Caps set these sizes before any buffer arrives, so they
// must not determine how much memory is used.
inline constexpr uint64_t kDryRunBytes = uint64_t{1} << 30;

// SPEC_MISMATCH for an open shape or one without a size; LIMIT_EXCEEDED above kDryRunBytes.
Status check_dry_run(std::span<const weir_tensor_info> inputs);

class DryRunInputs {
 public:
  // Allocates zeros in pages that stay unbacked until written. The errors of check_dry_run(), or
  // OUT_OF_MEMORY.
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
