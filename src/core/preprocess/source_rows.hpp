// SourceRows: the rows of a plane that a row of the tensor is made of.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir::preprocess {

// No CPU follows rows from page to page by itself: while it computes one row of the tensor, a
// kernel asks for what the next one is made of, a little in each step, for many requests at once
// would stop it.
struct SourceRows {
  const uint8_t* const* rows = nullptr;  // `count` of them
  const uint8_t* const* next = nullptr;  // as many, readable as far as those; may be the same
  size_t count = 0;
};

}  // namespace weir::preprocess
