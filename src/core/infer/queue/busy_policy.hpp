// Decides what happens to a frame that arrives while all workers of a model are busy. No threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir::infer {

enum class WhenBusy {
  Block,    // wait, and block the upstream thread
  DropNew,  // drop the new frame
  DropOld,  // drop the queued frame and queue the new one
};

struct PoolLimits {
  size_t workers = 1;
  WhenBusy when_busy = WhenBusy::Block;
  uint64_t bytes = 0;  // of all frames held; 0 = no limit

  // The number of frames that may be queued while every worker is busy. Block keeps one ready per
  // worker.
  size_t ahead() const noexcept {
    if (when_busy == WhenBusy::Block) return workers;
    return when_busy == WhenBusy::DropOld ? 1 : 0;
  }
};

// The current content of a pool.
struct PoolLoad {
  size_t working = 0, waiting = 0;  // frames
  uint64_t working_bytes = 0, waiting_bytes = 0;
};

enum class BusyDecision {
  Take,
  Wait,        // until a job is done
  DropNew,     // the new frame
  DropOldest,  // queued frame; then judge again
};

// Judges a frame of `bytes`. A frame above the limit is accepted when nothing else is held. A
// queued frame is not dropped for one that would not fit in its place.
BusyDecision judge(const PoolLimits& limits, const PoolLoad& load, uint64_t bytes) noexcept;

}  // namespace weir::infer
