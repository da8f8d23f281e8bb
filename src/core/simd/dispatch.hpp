// WEIR_DISPATCH_IF: a kernel for the best target of this CPU, or the one that runs on every CPU.
// Use it where hwy/highway.h is included, after HWY_EXPORT.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

// NOLINTBEGIN(bugprone-branch-clone): tools/lint compiles one target, where both are the same
#define WEIR_DISPATCH_IF(accelerate, f) \
  ((accelerate) ? HWY_DYNAMIC_DISPATCH(f) : HWY_STATIC_DISPATCH(f))
// NOLINTEND(bugprone-branch-clone)
