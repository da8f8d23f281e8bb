// Planes of elements that are no vector lanes, such as a pixel of three bytes. Included once per
// CPU target, inside Highway's foreach_target.
#if defined(WEIR_TRANSPOSE_PIXELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef WEIR_TRANSPOSE_PIXELS_INL
#undef WEIR_TRANSPOSE_PIXELS_INL
#else
#define WEIR_TRANSPOSE_PIXELS_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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

// Columns at a time: as many rows of the output grow from end to end, each line of it filled while
// it is in the cache. Caches fetch far apart lines to read before they are asked for, not to write.
constexpr size_t kPixelStrip = 128;

// kWide: as many bytes are moved, and the next pixel of the row of the output puts right what is
// too much. Neither the last row nor the last column can be moved so.
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
// Four by four pixels of three bytes, each widened to four on the way. Reads and writes 16 bytes
// for 12, but with kExact it writes 12.
template <bool kExact>
HWY_INLINE void move_triple_tile(const Pixels& pixels, size_t row, size_t column) noexcept {
  const hn::FixedTag<uint8_t, 16> d;
  const hn::FixedTag<uint32_t, 4> dw;
  alignas(16) static constexpr uint8_t kWiden[16] = {0, 1, 2, 3, 3, 4,  5,  6,
                                                     6, 7, 8, 9, 9, 10, 11, 12};
  alignas(16) static constexpr uint8_t kNarrow[16] = {0,  1,  2,  4,  5,  6,  8,  9,
                                                      10, 12, 13, 14, 15, 15, 15, 15};
  const auto widen = hn::Load(d, kWiden), narrow = hn::Load(d, kNarrow);
  const std::byte* in = pixels.from(row, column);
  std::byte* out = pixels.to(row, column);
  const size_t in_stride = pixels.in_stride, out_stride = pixels.out_stride;
  const auto load = [&](size_t r) HWY_ATTR {
    const auto x = hn::LoadU(d, reinterpret_cast<const uint8_t*>(in + r * in_stride));
    return hn::BitCast(dw, hn::TableLookupBytes(x, widen));
  };
  const auto store = [&](size_t c, auto x) HWY_ATTR {
    const auto packed = hn::TableLookupBytes(hn::BitCast(d, x), narrow);
    auto* to = reinterpret_cast<uint8_t*>(out + c * out_stride);
    if constexpr (kExact) {
      const hn::FixedTag<uint8_t, 8> half;
      hn::StoreU(hn::LowerHalf(half, packed), half, to);
      const uint32_t last = hn::ExtractLane(hn::BitCast(dw, packed), 2);
      std::memcpy(to + 8, &last, 4);
    } else {
      hn::StoreU(packed, d, to);
    }
  };
  const auto a = load(0), b = load(1), c = load(2), e = load(3);
  const auto ac_low = hn::InterleaveLower(dw, a, c), ac_high = hn::InterleaveUpper(dw, a, c);
  const auto be_low = hn::InterleaveLower(dw, b, e), be_high = hn::InterleaveUpper(dw, b, e);
  store(0, hn::InterleaveLower(dw, ac_low, be_low));
  store(1, hn::InterleaveUpper(dw, ac_low, be_low));
  store(2, hn::InterleaveLower(dw, ac_high, be_high));
  store(3, hn::InterleaveUpper(dw, ac_high, be_high));
}

// A tile takes two pixels more of each row than it has, and puts as many behind it, where tiles and
// rows that follow put them right; the last rows of tiles are exact.
void move_triples(const Pixels& pixels) noexcept {
  const size_t rows = pixels.rows / 4 * 4;
  const size_t columns = pixels.columns < 6 ? 0 : (pixels.columns - 2) / 4 * 4;
  const size_t spilling_rows = pixels.rows < 6 ? 0 : (pixels.rows - 2) / 4 * 4;
  for (size_t strip = 0; strip < pixels.columns; strip += kPixelStrip) {
    const size_t end = std::min(strip + kPixelStrip, pixels.columns);
    const size_t whole = std::max(strip, std::min(end, columns));
    for (size_t r = 0; r < rows; r += 4) {
      for (size_t c = strip; c < whole; c += 4) {
        if (r < spilling_rows)
          move_triple_tile<false>(pixels, r, c);
        else
          move_triple_tile<true>(pixels, r, c);
      }
      for (size_t i = r; i < r + 4; ++i) move_row<3, 3>(pixels, i, whole, end);
    }
    for (size_t r = rows; r < pixels.rows; ++r) move_row<3, 3>(pixels, r, strip, end);
  }
}
#endif

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
