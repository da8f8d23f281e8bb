// Occupancy: the mean number of busy workers over time. The caller passes the time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstddef>

namespace weir::infer {

class Occupancy {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Times must not decrease.
  void begin(Time now) noexcept {
    if (!begun_) first_ = last_ = now;
    begun_ = true;
    pass(now);
    ++busy_;
  }
  void end(Time now) noexcept {
    pass(now);
    --busy_;
  }
  size_t busy() const noexcept { return busy_; }
  // The mean since the first worker began; 0 before.
  double mean(Time now) const noexcept {
    if (!begun_ || now <= first_) return static_cast<double>(busy_);
    const auto present = (now - last_) * static_cast<std::ptrdiff_t>(busy_);
    return std::chrono::duration<double>(worked_ + present) /
           std::chrono::duration<double>(now - first_);
  }

 private:
  void pass(Time now) noexcept {
    worked_ += (now - last_) * static_cast<std::ptrdiff_t>(busy_);
    last_ = now;
  }
  bool begun_ = false;
  size_t busy_ = 0;
  Time first_, last_;
  Time::duration worked_{};  // of all workers together
};

}  // namespace weir::infer
