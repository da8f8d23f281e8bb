// SourceRows: the source rows that make one row of the tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir::preprocess {

// CPUs do not prefetch across pages. While a kernel computes one row of the tensor, it therefore
// prefetches the source rows of the next one, a little in each step, because many requests at once
// would stall it.
struct SourceRows {
  const uint8_t* const* rows = nullptr;  // `count` rows
  // As many rows, readable to the same length; may equal `rows`.
  const uint8_t* const* next = nullptr;
  size_t count = 0;
};

}  // namespace weir::preprocess
