// Waiting for boxes.
#include "core/preprocess/box_queue.hpp"

#include <algorithm>
#include <utility>

namespace weir::preprocess {

void BoxQueue::bring(int64_t time, std::vector<Box> boxes) {
  std::lock_guard lock(mutex_);
  if (flushing_) return;
  reached_ = std::max(reached_, time);
  sets_.push_back({time, std::move(boxes)});
  if (sets_.size() > kBoxQueueLimit) {
    sets_.pop_front();
    ++unused_;
  }
  changed_.notify_all();
}

void BoxQueue::advance(int64_t time) {
  std::lock_guard lock(mutex_);
  reached_ = std::max(reached_, time);
  changed_.notify_all();
}

void BoxQueue::end() {
  std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

constexpr std::chrono::hours kLongest{24};  // longer waits would be beyond the clock's range

BoxQueue::Outcome BoxQueue::take(int64_t time, std::chrono::nanoseconds most,
                                 std::vector<Box>* out) {
  out->clear();
  std::unique_lock lock(mutex_);
  const auto decided = [&] {
    while (!sets_.empty() && sets_.front().time < time) {
      sets_.pop_front();
      ++unused_;
    }
    return flushing_ || ended_ || !sets_.empty() || reached_ > time;
  };
  const bool in_time =
      changed_.wait_for(lock, std::min<std::chrono::nanoseconds>(most, kLongest), decided);
  if (flushing_) return Outcome::Flushed;
  if (!sets_.empty() && sets_.front().time == time) {
    *out = std::move(sets_.front().boxes);
    sets_.pop_front();
    return Outcome::Found;
  }
  return in_time ? Outcome::None : Outcome::Late;
}

void BoxQueue::flush(bool on) {
  std::lock_guard lock(mutex_);
  flushing_ = on;
  changed_.notify_all();
}

void BoxQueue::clear() {
  std::lock_guard lock(mutex_);
  unused_ += sets_.size();
  sets_.clear();
  reached_ = INT64_MIN;
  ended_ = false;
  changed_.notify_all();
}

uint64_t BoxQueue::unused() const {
  std::lock_guard lock(mutex_);
  return unused_;
}

}  // namespace weir::preprocess
