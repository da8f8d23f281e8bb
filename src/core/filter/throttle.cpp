// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/throttle.hpp"

#include <algorithm>

namespace weir {

void Throttle::limit(uint64_t delay) noexcept {
  uint64_t known = delay_;
  while ((known == 0 || delay < known) && !delay_.compare_exchange_weak(known, delay)) {
  }
}

std::optional<Throttle::Overflow> Throttle::refuses(uint64_t time, std::optional<uint64_t> duration,
                                                    uint64_t latency) noexcept {
  constexpr uint64_t kMax = INT64_MAX;
  const uint64_t delay = std::min(delay_.load(), kMax);
  const bool first = !before_;
  const uint64_t distance = before_ && time > *before_ ? time - *before_ : 0;
  before_ = time;
  accumulated_ = std::min(std::min(distance, kMax) + accumulated_, kMax);
  if (first || delay == 0 || accumulated_ >= std::max(latency, delay)) {
    accumulated_ = 0;
    return std::nullopt;
  }
  return Overflow{
      static_cast<double>(duration.value_or(distance)) / static_cast<double>(delay),
      static_cast<int64_t>(accumulated_) - static_cast<int64_t>(delay),
  };
}

void Throttle::restart() noexcept {
  before_.reset();
  accumulated_ = 0;
}

void Throttle::reset() noexcept {
  restart();
  delay_ = 0;
}

}  // namespace weir
