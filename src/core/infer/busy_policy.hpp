// What becomes of a frame that comes while the workers of a model are busy. No threads.
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir::infer {

enum class WhenBusy {
  Block,    // it waits, and whoever brings it
  DropNew,  // it is dropped
  DropOld,  // it takes the place of the one that waits
};

struct PoolLimits {
  size_t workers = 1;
  WhenBusy when_busy = WhenBusy::Block;
  uint64_t bytes = 0;  // of all that is held; 0 = any

  // Frames that may wait while every worker is busy. Who blocks has one ready for each worker.
  size_t ahead() const noexcept {
    if (when_busy == WhenBusy::Block) return workers;
    return when_busy == WhenBusy::DropOld ? 1 : 0;
  }
};

// What a pool holds.
struct PoolLoad {
  size_t working = 0, waiting = 0;  // frames
  uint64_t working_bytes = 0, waiting_bytes = 0;
};

enum class Verdict {
  Take,
  Wait,        // until something is done
  DropNew,     // the frame that comes
  DropOldest,  // of those that wait; then ask again
};

// For a frame of `bytes`. One that is bigger than the limit alone is taken when nothing else is
// held. A frame that waits is not dropped for one that could not be taken in its place.
Verdict judge(const PoolLimits& limits, const PoolLoad& load, uint64_t bytes) noexcept;

}  // namespace weir::infer
