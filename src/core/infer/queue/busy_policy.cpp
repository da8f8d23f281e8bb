// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/busy_policy.hpp"

namespace weir::infer {
namespace {

bool fits(const PoolLimits& limits, const PoolLoad& load, uint64_t bytes) noexcept {
  const size_t frames = load.working + load.waiting;
  if (frames >= limits.workers + limits.ahead()) return false;
  if (limits.bytes == 0 || frames == 0) return true;
  const uint64_t held = load.working_bytes + load.waiting_bytes;
  return held <= limits.bytes && bytes <= limits.bytes - held;
}

}  // namespace

BusyDecision judge(const PoolLimits& limits, const PoolLoad& load, uint64_t bytes) noexcept {
  if (fits(limits, load, bytes)) return BusyDecision::Take;
  if (limits.when_busy == WhenBusy::Block) return BusyDecision::Wait;
  const bool in_their_place =
      load.waiting > 0 && fits(limits, {load.working, 0, load.working_bytes, 0}, bytes);
  return limits.when_busy == WhenBusy::DropOld && in_their_place ? BusyDecision::DropOldest
                                                                 : BusyDecision::DropNew;
}

}  // namespace weir::infer
