// ClockOffset: how far a server's wall clock is ahead of this machine's, from four stamps of
// requests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <optional>

namespace weir::net {

// Not thread-safe.
class ClockOffset {
 public:
  // The true offset is within `error` of `offset`: half the round trip without the time in the
  // server. Both in nanoseconds.
  struct Estimate {
    int64_t offset = 0, error = 0;
  };
  static constexpr size_t kKept = 64;

  // Nanoseconds since 1970, below 2^62: by this machine's clock when the request was sent and its
  // response arrived, by the server's when it received and answered it. Stamps that cannot be, of
  // clocks that were set in between, are left out.
  void add(int64_t sent, int64_t received, int64_t answered, int64_t arrived) noexcept {
    const int64_t error = ((arrived - sent) - (answered - received)) / 2;
    if (error < 0) return;
    const int64_t out = received - sent, back = answered - arrived;
    kept_[count_ % kKept] = {out / 2 + back / 2 + (out % 2 + back % 2) / 2, error};
    ++count_;
  }
  // Returns the most exact of the last 64, since clocks drift.
  std::optional<Estimate> estimate() const noexcept {
    if (count_ == 0) return std::nullopt;
    Estimate best = kept_[0];
    for (size_t i = 1; i < kKept && i < count_; ++i)
      if (kept_[i].error < best.error) best = kept_[i];
    return best;
  }

 private:
  std::array<Estimate, kKept> kept_{};
  size_t count_ = 0;
};

}  // namespace weir::net
