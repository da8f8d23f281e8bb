// BoxQueue: finds the boxes of a picture's time among those that another thread brings.
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

#include "core/preprocess/boxes.hpp"

namespace weir::preprocess {

inline constexpr size_t kBoxQueueLimit = 256;  // sets of boxes that wait for their picture

// Times in nanoseconds, of one clock for pictures and boxes; neither may go back but by a flush.
// One thread brings, one takes.
class BoxQueue {
 public:
  enum class Outcome {
    Found,    // boxes of the same time
    None,     // boxes of a later time, or no more of them: none of this time will come
    Late,     // they did not come in time
    Flushed,  // the taker shall go
  };

  // Beyond the limit the oldest set goes.
  void bring(int64_t time, std::vector<Box> boxes);
  // No boxes before `time` will come.
  void advance(int64_t time);
  // No boxes at all will come, until clear().
  void end();
  // Sets of an older time go. Waits for those of this time at most so long.
  Outcome take(int64_t time, std::chrono::nanoseconds most, std::vector<Box>* out);
  // While on, take() returns at once.
  void flush(bool on);
  // Of a new stream: all that waits goes, boxes may come again.
  void clear();

  uint64_t unused() const;  // sets that met no picture

 private:
  struct Set {
    int64_t time;
    std::vector<Box> boxes;
  };
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::deque<Set> sets_;
  int64_t reached_ = INT64_MIN;  // boxes that come are of this time or later
  bool ended_ = false, flushing_ = false;
  uint64_t unused_ = 0;
};

}  // namespace weir::preprocess
