// Where the pairs lie.
#include "core/preprocess/pair_columns.hpp"

#include <algorithm>

#include "core/preprocess/row_kernels.hpp"

namespace weir::preprocess {

int16_t pair_share(double second) noexcept {
  return static_cast<int16_t>(-static_cast<int32_t>(second * 32768 + 0.5));
}

void PairColumns::lay(const Axis& axis, size_t sample_bytes) {
  step = sample_bytes;
  count = axis.targets();
  const size_t lanes = pair_lanes(step);
  at.resize(count);
  shares.assign(padded(count) * lanes, 0);
  for (size_t t = 0; t < count; ++t) {
    const auto weights = axis.weights(t);
    // Where there is none behind the last sample: a pair of which only the second counts.
    const uint32_t first = std::min(axis.first(t), axis.high() - 2);
    const double second = weights.size() == 2 ? double{weights[1]} : axis.first(t) - first;
    at[t] = static_cast<uint32_t>((first - axis.low()) * step);
    std::fill_n(shares.begin() + static_cast<ptrdiff_t>(t * lanes), lanes, pair_share(second));
  }
  lay_windows((axis.high() - axis.low()) * step);
}

bool PairColumns::fits(size_t pixels, size_t row_bytes) const noexcept {
  if (row_bytes < kWindow) return false;
  for (size_t t = 0; t < count; t += pixels)
    if (at[std::min(t + pixels, count) - 1] + 2 * step > at[t] + kWindow) return false;
  return true;
}

void PairColumns::lay_windows(size_t row_bytes) {
  const size_t most = kWindow / pair_bytes(step);
  group = fits(most, row_bytes) ? most : most > 2 && fits(most / 2, row_bytes) ? most / 2 : 1;
  windows.clear();
  if (group == 1) return;
  lookup.assign((count + group - 1) / group * kWindow, 0);
  for (size_t t = 0; t < count; ++t) {
    if (t % group == 0)
      windows.push_back(std::min(at[t], static_cast<uint32_t>(row_bytes - kWindow)));
    uint8_t* const to = &lookup[t / group * kWindow + t % group * pair_bytes(step)];
    for (size_t b = 0; b < 2 * step; ++b) to[b] = static_cast<uint8_t>(at[t] - windows.back() + b);
  }
}

}  // namespace weir::preprocess
