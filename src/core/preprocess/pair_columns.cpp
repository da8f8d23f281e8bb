// Lays out the lookup tables of pairs of samples.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/pair_columns.hpp"

#include <algorithm>
#include <bit>

#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/wide_windows.hpp"

namespace weir::preprocess {
namespace {

// Offset of the low byte of a lane of 16 bits.
constexpr size_t low_byte(size_t lane) noexcept {
  return lane * sizeof(int16_t) + (std::endian::native == std::endian::little ? 0 : 1);
}

}  // namespace

int16_t pair_share(double second) noexcept {
  return static_cast<int16_t>(-static_cast<int32_t>(second * 32768 + 0.5));
}

void PairColumns::lay(const Axis& axis, size_t sample_bytes) {
  step = sample_bytes;
  count = axis.targets();
  const size_t lanes = pair_lanes(step);
  at.resize(count);
  shares.assign(padded(count) * lanes + kWideLanes, 0);
  for (size_t t = 0; t < count; ++t) {
    const auto weights = axis.weights(t);
    // If no sample follows, the pair ends with this sample and only its second sample counts.
    const uint32_t first = std::min(axis.first(t), axis.high() - 2);
    const double second = weights.size() == 2 ? double{weights[1]} : axis.first(t) - first;
    at[t] = static_cast<uint32_t>((first - axis.low()) * step);
    std::fill_n(shares.begin() + static_cast<ptrdiff_t>(t * lanes), lanes, pair_share(second));
  }
  group = 1;
  wide = 0;
  const size_t row_bytes = (axis.high() - axis.low()) * step;
  if (has_wide_windows()) lay_wide_windows(row_bytes);
  if (wide == 0) lay_windows(row_bytes);
}

bool PairColumns::fits(size_t pixels, size_t window, size_t row_bytes) const noexcept {
  if (row_bytes < window) return false;
  for (size_t t = 0; t < count; t += pixels)
    if (at[std::min(t + pixels, count) - 1] + 2 * step > at[t] + window) return false;
  return true;
}

void PairColumns::lay_wide_windows(size_t row_bytes) {
  const size_t lanes = pair_lanes(step);
  const auto vectors_for = [&](size_t pixels) -> size_t {
    for (size_t vectors = 1; vectors <= kWideVectors; ++vectors)
      if (fits(pixels, vectors * kWideBytes, row_bytes)) return vectors;
    return 0;
  };
  wide_lanes = kWideLanes;
  while ((wide = vectors_for(wide_lanes / lanes)) == 0 && wide_lanes > kFewestWideLanes)
    wide_lanes /= 2;
  if (wide == 0) return;
  const size_t pixels = wide_lanes / lanes;
  windows[0].assign((count + pixels - 1) / pixels, 0);
  lookup[0][0].assign(windows[0].size() * kWideBytes, 0);
  for (size_t t = 0; t < count; ++t) {
    uint32_t& window = windows[0][t / pixels];
    if (t % pixels == 0)
      window = std::min(at[t], static_cast<uint32_t>(row_bytes - wide * kWideBytes));
    uint8_t* const places =
        lookup[0][0].data() + t / pixels * kWideBytes + 2 * (t % pixels * lanes);
    for (size_t l = 0; l < step; ++l) {
      places[2 * l] = static_cast<uint8_t>(at[t] - window + l);
      places[2 * l + 1] = static_cast<uint8_t>(at[t] - window + l + step);
    }
  }
}

void PairColumns::lay_windows(size_t row_bytes) {
  const size_t lanes = pair_lanes(step), most = kBlockLanes / lanes;
  group = fits(most, kWindow, row_bytes)                   ? most
          : most > 2 && fits(most / 2, kWindow, row_bytes) ? most / 2
                                                           : 1;
  if (group == 1) return;
  const size_t blocks = (count + most - 1) / most;
  const size_t padded_blocks = (blocks + kBlocksPadded - 1) / kBlocksPadded * kBlocksPadded;
  for (size_t p = 0; p < parts(); ++p) {
    windows[p].assign(padded_blocks, 0);
    for (auto& samples : lookup[p]) samples.assign(padded_blocks * kWindow, kNothingHere);
  }
  for (size_t t = 0; t < count; ++t) {
    const size_t block = t / most, part = t % most / group;
    uint32_t& window = windows[part][block];
    if (t % group == 0) window = std::min(at[t], static_cast<uint32_t>(row_bytes - kWindow));
    for (size_t sample = 0; sample < 2; ++sample)
      for (size_t l = 0; l < step; ++l)
        lookup[part][sample][block * kWindow + low_byte(t % most * lanes + l)] =
            static_cast<uint8_t>(at[t] - window + sample * step + l);
  }
}

}  // namespace weir::preprocess
