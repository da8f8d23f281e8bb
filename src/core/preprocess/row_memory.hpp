// RowMemory: a vector aligned to cache lines, so that no SIMD load of a row spans two lines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <new>
#include <vector>

namespace weir::preprocess {

template <class T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64};

  LineAllocator() = default;
  template <class Other>
  LineAllocator(const LineAllocator<Other>&) noexcept {}

  T* allocate(size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kLine)); }
  void deallocate(T* memory, size_t) noexcept { ::operator delete(memory, kLine); }
  bool operator==(const LineAllocator&) const = default;
};

template <class T>
using RowMemory = std::vector<T, LineAllocator<T>>;

}  // namespace weir::preprocess
