// make_fused_kernel: runs two kernels block by block, so that the intermediate result stays in the
// L1 cache.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/kernel.hpp"

namespace weir::transform {

struct FusedPart {
  std::shared_ptr<const Kernel> kernel;
  ElementType from, to;
};

// For a tensor of `count` elements. nullptr if a part is not element-wise or its period exceeds a
// block.
std::shared_ptr<const Kernel> make_fused_kernel(FusedPart first, FusedPart second, size_t count);

}  // namespace weir::transform
