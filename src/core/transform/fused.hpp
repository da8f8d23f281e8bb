// Two kernels one after the other, block by block: what lies between them stays in the L1 cache.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

struct FusedPart {
  std::shared_ptr<const Kernel> kernel;
  ElementType from, to;
};

// For a tensor of `count` elements. nullptr when a part is not element-wise, or repeats only after
// more elements than a block can have.
std::shared_ptr<const Kernel> make_fused_kernel(FusedPart first, FusedPart second, size_t count);

}  // namespace weir::transform
