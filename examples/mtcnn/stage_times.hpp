// When each picture reached which point of the cascade, on one clock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace mtcnn {

enum class Stage : uint8_t {
  Begin,
  Proposed,
  Refined,
  Marked
};  // the ends of P-, R-, O-Net's part
inline constexpr size_t kStages = 4;

class StageTimes {
 public:
  using Clock = std::chrono::steady_clock;
  // The picture of this time-stamp (ns) is there now, or was at `time`. Any thread.
  void reached(Stage stage, int64_t pts, Clock::time_point time = Clock::now());
  // A picture is shown now. Any thread.
  void shown();
  // Bytes that were copied for all pictures together. Any thread.
  void copied(uint64_t bytes);
  // {"pictures": [[begin, proposed, refined, marked], ...], "begun": pictures that the networks
  // got, "shown": [time, ...], "copied": bytes or null} in seconds of a clock that only goes on, in
  // the order of time-stamps; pictures that did not come through are left out. FILE_NOT_WRITTEN.
  weir::Status write(const std::string& file) const;

 private:
  mutable std::mutex mutex_;
  // Under mutex_:
  std::map<int64_t, std::array<Clock::time_point, kStages>> times_;
  std::vector<Clock::time_point> shown_;
  std::optional<uint64_t> copied_;
};

}  // namespace mtcnn
