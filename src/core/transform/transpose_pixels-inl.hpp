// Transposes planes of elements that do not fit vector lanes, such as three-byte pixels. Included
// once per CPU target, inside Highway's foreach_target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#if defined(WEIR_TRANSPOSE_PIXELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef WEIR_TRANSPOSE_PIXELS_INL
#undef WEIR_TRANSPOSE_PIXELS_INL
#else
#define WEIR_TRANSPOSE_PIXELS_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Tiles consist of 16-byte blocks; this many are side by side in a vector.
inline constexpr size_t kTileBlocks = !HWY_HAVE_SCALABLE && HWY_LANES(uint8_t) >= 32 ? 2 : 1;

// A plane. Sizes are in bytes.
struct Pixels {
  const std::byte* in;
  std::byte* out;
  size_t rows, columns, bytes;
  size_t in_stride, out_stride;

  const std::byte* from(size_t row, size_t column) const noexcept {
    return in + row * in_stride + column * bytes;
  }
  std::byte* to(size_t row, size_t column) const noexcept {
    return out + column * out_stride + row * bytes;
  }
};

// Columns at a time: this many output rows grow together, each line filled while it is in the
// cache. CPUs prefetch distant lines for reads, but not for writes.
constexpr size_t kPixelStrip = 128;

// kWide: moves this many bytes; the next pixel of the output row overwrites the excess. Not
// possible for the last row and the last column.
template <size_t kBytes, size_t kWide>
HWY_INLINE void move_row(const Pixels& pixels, size_t row, size_t column, size_t end) noexcept {
  const size_t bytes = kBytes > 0 ? kBytes : pixels.bytes, stride = pixels.out_stride;
  const std::byte* in = pixels.from(row, column);
  std::byte* out = pixels.to(row, column);
  const bool is_last = row + 1 == pixels.rows;
  const size_t wide_end = is_last || kWide <= kBytes ? column : std::min(end, pixels.columns - 1);
  for (; column < wide_end; ++column, in += bytes, out += stride) std::memcpy(out, in, kWide);
  for (; column < end; ++column, in += bytes, out += stride) std::memcpy(out, in, bytes);
}

template <size_t kBytes, size_t kWide>
void move_pixels(const Pixels& pixels) noexcept {
  for (size_t c = 0; c < pixels.columns; c += kPixelStrip)
    for (size_t r = 0; r < pixels.rows; ++r)
      move_row<kBytes, kWide>(pixels, r, c, std::min(c + kPixelStrip, pixels.columns));
}

#if HWY_TARGET == HWY_SCALAR
void move_triples(const Pixels& pixels) noexcept {
  move_pixels<3, 3>(pixels);
}
#else
// The byte places of four pixels. The pixel of column c of row r is at place c ^ r of its vector,
// so that rows are exchanged by selecting from two vectors, which moves nothing and is cheap.
struct TripleTables {
  alignas(32) uint8_t widen[4][32];   // by row: three bytes to four, in each block of 16
  alignas(32) uint8_t narrow[4][32];  // by column: back to three, in the order of the rows
};
constexpr TripleTables triple_tables() {
  TripleTables tables{};
  for (size_t row = 0; row < 4; ++row)
    for (size_t i = 0; i < 32; ++i) {
      const size_t at = i % 16, place = at / 4, triple = at / 3;
      tables.widen[row][i] = static_cast<uint8_t>((place ^ row) * 3 + at % 4);
      tables.narrow[row][i] =
          static_cast<uint8_t>(at < 12 ? (triple ^ row) * 4 + at % 3 : size_t{15});
    }
  return tables;
}
alignas(32) inline constexpr TripleTables kTriples = triple_tables();

// Transposes kBlocks times four rows by four columns of three-byte pixels. Reads 16 bytes for each
// 12 of a row. Also writes the next 4 or 8 bytes of each column unless kExact, which requires one
// block.
template <size_t kBlocks, bool kExact>
HWY_INLINE void move_triple_tile(const Pixels& pixels, size_t row, size_t column) noexcept {
  const hn::FixedTag<uint8_t, 16> block;
  const hn::FixedTag<uint8_t, 16 * kBlocks> d;
  const hn::FixedTag<uint32_t, 4 * kBlocks> dw;
  const hn::FixedTag<uint64_t, 2 * kBlocks> dq;
  const auto* in = reinterpret_cast<const uint8_t*>(pixels.from(row, column));
  auto* out = reinterpret_cast<uint8_t*>(pixels.to(row, column));
  const size_t in_stride = pixels.in_stride, out_stride = pixels.out_stride;
  const auto load = [&](size_t r) HWY_ATTR {
    const auto first = hn::LoadU(block, in + r * in_stride);
    const auto widen = hn::Load(d, kTriples.widen[r]);
    if constexpr (kBlocks == 1)
      return hn::BitCast(dq, hn::TableLookupBytes(first, widen));
    else
      return hn::BitCast(
          dq, hn::TableLookupBytes(
                  hn::Combine(d, hn::LoadU(block, in + (r + 4) * in_stride), first), widen));
  };
  const auto store = [&](size_t c, auto x) HWY_ATTR {
    const auto packed = hn::TableLookupBytes(hn::BitCast(d, x), hn::Load(d, kTriples.narrow[c]));
    uint8_t* to = out + c * out_stride;
    if constexpr (kExact) {
      const hn::FixedTag<uint8_t, 8> half;
      hn::StoreU(hn::LowerHalf(half, packed), half, to);
      const uint32_t last = hn::ExtractLane(hn::BitCast(dw, packed), 2);
      std::memcpy(to + 8, &last, 4);
    } else if constexpr (kBlocks == 1) {
      hn::StoreU(packed, d, to);
    } else {
      alignas(32) static constexpr uint32_t kTogether[8] = {0, 1, 2, 4, 5, 6, 7, 7};
      const auto together = hn::SetTableIndices(dw, kTogether);
      hn::StoreU(hn::BitCast(d, hn::TableLookupLanes(hn::BitCast(dw, packed), together)), d, to);
    }
  };
  const auto pick = [&](auto odd, auto even)
                        HWY_ATTR { return hn::BitCast(dw, hn::OddEven(odd, even)); };
  const auto a = load(0), b = load(1), c = load(2), e = load(3);
  const auto ac = pick(c, a), be = pick(e, b), ca = pick(a, c), eb = pick(b, e);
  store(0, hn::OddEven(be, ac));
  store(1, hn::OddEven(ac, be));
  store(2, hn::OddEven(eb, ca));
  store(3, hn::OddEven(ca, eb));
}

// A tile reads two pixels beyond its part of each row and writes some after its columns, which
// later tiles and rows overwrite; the last rows of tiles are exact.
void move_triples(const Pixels& plane) noexcept {
  const Pixels pixels = plane;  // a local copy: the stores might alias `plane`
  constexpr size_t kBlocks = kTileBlocks, kRows = 4 * kBlocks, kSpilt = kBlocks == 1 ? 2 : 3;
  const size_t columns = pixels.columns < 6 ? 0 : (pixels.columns - 2) / 4 * 4;
  for (size_t strip = 0; strip < pixels.columns; strip += kPixelStrip) {
    const size_t end = std::min(strip + kPixelStrip, pixels.columns);
    const size_t whole = std::max(strip, std::min(end, columns));
    const auto rest = [&](size_t from, size_t to) HWY_ATTR {
      for (size_t r = from; whole < end && r < to; ++r) move_row<3, 3>(pixels, r, whole, end);
    };
    size_t r = 0;
    for (; r + kRows + kSpilt <= pixels.rows; r += kRows) {
      for (size_t c = strip; c < whole; c += 4) move_triple_tile<kBlocks, false>(pixels, r, c);
      rest(r, r + kRows);
    }
    for (; r + 4 <= pixels.rows; r += 4) {
      for (size_t c = strip; c < whole; c += 4) move_triple_tile<1, true>(pixels, r, c);
      rest(r, r + 4);
    }
    for (; r < pixels.rows; ++r) move_row<3, 3>(pixels, r, strip, end);
  }
}
#endif

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
