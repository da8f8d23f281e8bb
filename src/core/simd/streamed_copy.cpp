// Copies whole cache lines with non-temporal stores. The ends are copied normally, because a partly
// streamed line costs more than it saves.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/simd/streamed_copy.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/simd/streamed_copy.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Copies `lines` lines of 64 bytes; `to` is aligned to a line.
void stream_lines(uint8_t* to, const uint8_t* from, size_t lines) {
  constexpr size_t kLine = 64;
#if HWY_TARGET == HWY_SCALAR
  std::memcpy(to, from, lines * kLine);
#else
  const hn::CappedTag<uint8_t, kLine> d;
  for (; lines > 0; --lines, to += kLine, from += kLine)
    for (size_t i = 0; i < kLine; i += hn::Lanes(d)) hn::Stream(hn::LoadU(d, from + i), d, to + i);
#endif
}

}  // namespace weir::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir {

HWY_EXPORT(stream_lines);

void copy_streamed(std::byte* to, const std::byte* from, size_t bytes) noexcept {
  constexpr size_t kLine = 64;
  const size_t head = std::min((kLine - reinterpret_cast<uintptr_t>(to) % kLine) % kLine, bytes);
  const size_t lines = (bytes - head) / kLine, done = head + lines * kLine;
  if (head > 0) std::memcpy(to, from, head);
  HWY_DYNAMIC_DISPATCH(stream_lines)
  (reinterpret_cast<uint8_t*>(to + head), reinterpret_cast<const uint8_t*>(from + head), lines);
  if (done < bytes) std::memcpy(to + done, from + done, bytes - done);
}

void flush_streamed() noexcept {
  hwy::FlushStream();
}

}  // namespace weir
#endif
