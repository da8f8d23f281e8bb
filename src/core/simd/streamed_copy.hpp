// Copies of large blocks past the caches: a cache would read each line before it is written, and
// give it up again before it is read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>

namespace weir {

// `to` and `from` do not overlap. Others see the bytes after flush_streamed().
void copy_streamed(std::byte* to, const std::byte* from, size_t bytes) noexcept;
void flush_streamed() noexcept;

}  // namespace weir
