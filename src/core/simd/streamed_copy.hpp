// Copies large blocks with non-temporal stores. Normal stores would first read each line into the
// cache, which evicts it before anyone reads it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>

namespace weir {

// `to` and `from` do not overlap. Other threads see the bytes after flush_streamed().
void copy_streamed(std::byte* to, const std::byte* from, size_t bytes) noexcept;
void flush_streamed() noexcept;

}  // namespace weir
