// StageTimes: when each picture reached each stage of the cascade, on one clock.
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
};  // the ends of P-, R- and O-Net's stages
inline constexpr size_t kStages = 4;

class StageTimes {
 public:
  using Clock = std::chrono::steady_clock;
  // Records that the picture with this timestamp (ns) has reached `stage` at `time`. Any thread.
  void reached(Stage stage, int64_t pts, Clock::time_point time = Clock::now());
  // Records that a picture is shown now. Any thread.
  void shown();
  // Sets the bytes copied for all pictures together. Any thread.
  void copied(uint64_t bytes);
  // Writes {"pictures": [[begin, proposed, refined, marked], ...], "begun": pictures that reached
  // the networks, "shown": [time, ...], "copied": bytes or null}, in seconds of a monotonic clock,
  // in order of timestamps; unfinished pictures are omitted. FILE_NOT_WRITTEN.
  weir::Status write(const std::string& file) const;

 private:
  mutable std::mutex mutex_;
  // Guarded by mutex_:
  std::map<int64_t, std::array<Clock::time_point, kStages>> times_;
  std::vector<Clock::time_point> shown_;
  std::optional<uint64_t> copied_;
};

}  // namespace mtcnn
