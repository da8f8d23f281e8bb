// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/held_bytes.hpp"

#include <algorithm>

namespace weir::infer {

void HeldBytes::add(uint64_t* to, uint64_t bytes) noexcept {
  *to += bytes;
  peak_ = std::max(peak_, held());
}

HeldBytes::FrameAdmission HeldBytes::try_frame(const std::shared_ptr<HeldBytes>& held,
                                               uint64_t bytes, Share* share) {
  {
    Lock lock(held->mutex_);
    if (held->refuses_frames_) return FrameAdmission::Refused;
    if (!held->frame_fits(bytes)) return FrameAdmission::Full;
    held->add(&held->frames_, bytes);
  }
  share->held_ = held;
  share->bytes_ = bytes;
  return FrameAdmission::Taken;
}

HeldBytes::FrameAdmission HeldBytes::take_frame(const std::shared_ptr<HeldBytes>& held,
                                                uint64_t bytes, Share* share) {
  if (held->when_busy_ == WhenBusy::Block) {
    Lock lock(held->mutex_);
    ++held->frames_waiting_;
    held->changed_.wait(lock, [&] { return held->refuses_frames_ || held->frame_fits(bytes); });
    --held->frames_waiting_;
  }
  return try_frame(held, bytes, share);  // only one thread adds frames, so the space is still there
}

void HeldBytes::release_frame(uint64_t bytes) {
  Lock lock(mutex_);
  frames_ -= bytes;
  changed_.notify_all();
}

// A result is dropped: the oldest one that waits, or the new one, for which it returns false.
bool HeldBytes::drop_oldest(Results& results) {
  ++dropped_;
  const auto freed = when_busy_ == WhenBusy::DropOld ? results.drop_oldest() : std::nullopt;
  results_ -= freed.value_or(0);
  return freed.has_value();
}

HeldBytes::Room HeldBytes::take_result(uint64_t bytes, Results& results) {
  Lock lock(mutex_);
  for (;;) {
    if (refuses_results_) return Room::Refused;
    if (fits(bytes) || results_ == 0) break;
    const bool others_leave = results.leave();
    if (!others_leave && results.is_next()) break;
    if (when_busy_ == WhenBusy::Block) {
      if (!others_leave) return Room::Stuck;
      ++results_waiting_;
      changed_.wait(lock);
      --results_waiting_;
    } else if (!drop_oldest(results)) {
      return Room::Dropped;
    }
  }
  add(&results_, bytes);
  return Room::Taken;
}

void HeldBytes::release_result(uint64_t bytes) {
  Lock lock(mutex_);
  results_ -= bytes;
  changed_.notify_all();
}

void HeldBytes::moved() {
  Lock lock(mutex_);
  changed_.notify_all();
}

void HeldBytes::refuse() {
  Lock lock(mutex_);
  refuses_frames_ = refuses_results_ = true;
  changed_.notify_all();
}

void HeldBytes::refuse_frames() {
  Lock lock(mutex_);
  refuses_frames_ = true;
  changed_.notify_all();
}

void HeldBytes::resume() {
  Lock lock(mutex_);
  refuses_frames_ = refuses_results_ = false;
}

HeldBytes::State HeldBytes::state() const {
  Lock lock(mutex_);
  return {held(), peak_, dropped_, frames_waiting_ > 0, results_waiting_ > 0};
}

}  // namespace weir::infer
