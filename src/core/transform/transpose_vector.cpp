// Fast transpositions: channel interleaving, and square tiles in registers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "core/transform/transpose_steps.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/transpose_vector.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#include "core/transform/transpose_pixels-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A part of a plane: rows run along the output, columns along the input. Strides are in elements.
template <class T>
struct Plane {
  const T* in;
  T* out;
  size_t rows, columns;  // elements contiguous in the output, in the input
  size_t in_stride,
      out_stride;  // from row to row in the input, from column to column in the output

  Plane part(size_t row, size_t column, size_t row_count, size_t column_count) const noexcept {
    return {in + row * in_stride + column,
            out + column * out_stride + row,
            row_count,
            column_count,
            in_stride,
            out_stride};
  }
};

// memcpy: the pointers may have any alignment.
template <class T>
HWY_INLINE void move_plainly(const Plane<T>& plane) noexcept {
  for (size_t c = 0; c < plane.columns; ++c)
    for (size_t r = 0; r < plane.rows; ++r)
      std::memcpy(plane.out + c * plane.out_stride + r, plane.in + r * plane.in_stride + c,
                  sizeof(T));
}

// 3:N -> N:3 and similar: `columns` channels are interleaved in the input.
template <class T>
void deinterleave(const Plane<T>& plane) noexcept {
  const hn::ScalableTag<T> d;
  const size_t lanes = hn::Lanes(d);
  T* const out = plane.out;
  const size_t stride = plane.out_stride;
  size_t r = 0;
  for (; r + lanes <= plane.rows; r += lanes) {
    const T* const in = plane.in + r * plane.columns;
    hn::Vec<decltype(d)> a, b, c, e;
    if (plane.columns == 2) {
      hn::LoadInterleaved2(d, in, a, b);
    } else if (plane.columns == 3) {
      hn::LoadInterleaved3(d, in, a, b, c);
      hn::StoreU(c, d, out + 2 * stride + r);
    } else {
      hn::LoadInterleaved4(d, in, a, b, c, e);
      hn::StoreU(c, d, out + 2 * stride + r);
      hn::StoreU(e, d, out + 3 * stride + r);
    }
    hn::StoreU(a, d, out + r);
    hn::StoreU(b, d, out + stride + r);
  }
  move_plainly(plane.part(r, 0, plane.rows - r, plane.columns));
}

// N:3 -> 3:N and similar: interleaves `rows` channels in the output.
template <class T>
void interleave(const Plane<T>& plane) noexcept {
  const hn::ScalableTag<T> d;
  const size_t lanes = hn::Lanes(d);
  const T* const in = plane.in;
  const size_t stride = plane.in_stride;
  size_t c = 0;
  for (; c + lanes <= plane.columns; c += lanes) {
    T* const out = plane.out + c * plane.rows;
    const auto v0 = hn::LoadU(d, in + c);
    const auto v1 = hn::LoadU(d, in + stride + c);
    if (plane.rows == 2) {
      hn::StoreInterleaved2(v0, v1, d, out);
    } else if (plane.rows == 3) {
      hn::StoreInterleaved3(v0, v1, hn::LoadU(d, in + 2 * stride + c), d, out);
    } else {
      hn::StoreInterleaved4(v0, v1, hn::LoadU(d, in + 2 * stride + c),
                            hn::LoadU(d, in + 3 * stride + c), d, out);
    }
  }
  move_plainly(plane.part(0, c, plane.rows, plane.columns - c));
}

#if HWY_TARGET == HWY_SCALAR
template <class T>
inline constexpr size_t kTile = 8;

template <size_t, class T>
void move_tile(const Plane<T>& plane) noexcept {
  move_plainly(plane);
}
#else
template <class T>
inline constexpr size_t kTile = 16 / sizeof(T);

// Transposes squares of 16-byte rows: one, or two above each other that make longer output rows.
// Interleaving the halves of the rows log2(rows) times transposes each.
template <size_t kBlocks, class T>
HWY_INLINE void move_tile(const Plane<T>& plane) noexcept {
  constexpr size_t kRows = kTile<T>;
  const hn::FixedTag<T, kRows> block;
  const hn::FixedTag<T, kRows * kBlocks> d;
  hn::Vec<decltype(d)> x[kRows], y[kRows];
  HWY_UNROLL(16)
  for (size_t i = 0; i < kRows; ++i) {
    const auto first = hn::LoadU(block, plane.in + i * plane.in_stride);
    if constexpr (kBlocks == 1)
      x[i] = first;
    else
      x[i] = hn::Combine(d, hn::LoadU(block, plane.in + (i + kRows) * plane.in_stride), first);
  }
  HWY_UNROLL(16)
  for (size_t stage = 1; stage < kRows; stage *= 2) {
    HWY_UNROLL(16)
    for (size_t i = 0; i < kRows / 2; ++i) {
      y[2 * i] = hn::InterleaveLower(d, x[i], x[i + kRows / 2]);
      y[2 * i + 1] = hn::InterleaveUpper(d, x[i], x[i + kRows / 2]);
    }
    HWY_UNROLL(16)
    for (size_t i = 0; i < kRows; ++i) x[i] = y[i];
  }
  HWY_UNROLL(16)
  for (size_t i = 0; i < kRows; ++i) hn::StoreU(x[i], d, plane.out + i * plane.out_stride);
}
#endif

// Processes tiles column by column within a strip of rows, so that output lines are filled while
// they are in the cache.
template <class T>
void move_tiles(const Plane<T>& plane) noexcept {
  constexpr size_t kSide = kTile<T>, kRows = kSide * kTileBlocks;
  constexpr size_t kStrip = std::max<size_t>(kRows, 128 / sizeof(T));  // rows: two lines, or more
  const size_t whole_columns = plane.columns / kSide * kSide;
  const size_t whole_rows = plane.rows / kSide * kSide;
  for (size_t strip = 0; strip < whole_rows; strip += kStrip) {
    const size_t end = std::min(strip + kStrip, whole_rows);
    for (size_t c = 0; c < whole_columns; c += kSide) {
      size_t r = strip;
      for (; r + kRows <= end; r += kRows) move_tile<kTileBlocks>(plane.part(r, c, kRows, kSide));
      for (; r < end; r += kSide) move_tile<1>(plane.part(r, c, kSide, kSide));
    }
    move_plainly(plane.part(strip, whole_columns, end - strip, plane.columns - whole_columns));
  }
  move_plainly(plane.part(whole_rows, 0, plane.rows - whole_rows, plane.columns));
}

template <class T>
void move_plane(const Plane<T>& plane) noexcept {
  const bool from_channels = plane.columns <= 4 && plane.in_stride == plane.columns;
  const bool to_channels = plane.rows <= 4 && plane.out_stride == plane.rows;
  if (from_channels) return deinterleave(plane);
  if (to_channels) return interleave(plane);
  move_tiles(plane);
}

template <class T>
void run_elements(const TransposeSteps& steps, const std::byte* in, std::byte* out) noexcept {
  for_each_plane(steps, in, out, [&](const std::byte* from, std::byte* to) HWY_ATTR {
    move_plane<T>({reinterpret_cast<const T*>(from), reinterpret_cast<T*>(to), steps.row.size,
                   steps.column.size, steps.row.in_stride, steps.column.out_stride});
  });
}

template <void kMove(const Pixels&) noexcept>
void run_pixels(const TransposeSteps& steps, const std::byte* in, std::byte* out) noexcept {
  const size_t bytes = steps.element_bytes;
  for_each_plane(steps, in, out, [&](const std::byte* from, std::byte* to) HWY_ATTR {
    kMove({from, to, steps.row.size, steps.column.size, bytes, steps.row.in_stride * bytes,
           steps.column.out_stride * bytes});
  });
}

void RunTranspose(const TransposeSteps& steps, const std::byte* in, std::byte* out) {
  switch (steps.element_bytes) {
    case 1:
      return run_elements<uint8_t>(steps, in, out);
    case 2:
      return run_elements<uint16_t>(steps, in, out);
    case 4:
      return run_elements<uint32_t>(steps, in, out);
    case 8:
      return run_elements<uint64_t>(steps, in, out);
    case 3:
      return run_pixels<move_triples>(steps, in, out);
    case 6:
      return run_pixels<move_pixels<6, 8>>(steps, in, out);
    case 12:
      return run_pixels<move_pixels<12, 16>>(steps, in, out);
    case 16:
      return run_pixels<move_pixels<16, 16>>(steps, in, out);
    default:
      return run_pixels<move_pixels<0, 0>>(steps, in, out);
  }
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunTranspose);

void run_transpose_vector(const TransposeSteps& steps, const std::byte* in,
                          std::byte* out) noexcept {
  HWY_DYNAMIC_DISPATCH(RunTranspose)(steps, in, out);
}

}  // namespace weir::transform
#endif
