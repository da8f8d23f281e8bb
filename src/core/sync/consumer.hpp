// Consumer: what a Collector makes outputs for: an element, which pushes them downstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/sync/input_queues.hpp"

namespace weir::sync {

// Results of offer(): 0, or a negative number if no further frame is accepted.
inline constexpr int kOk = 0, kNotLinked = -1, kFlushing = -2, kEnded = -3, kRefused = -5;

template <class Frame>
struct Consumer {
  virtual ~Consumer() = default;
  // One call at a time, without a lock. A result other than kOk is returned to every pad from then
  // on, except kNotLinked, which lasts only until an emit() succeeds, because pads are linked while
  // frames flow.
  virtual int emit(Emission<Frame> emission) = 0;
  virtual void end() = 0;  // no emission follows until a flush
  virtual void refused(const Error& error) = 0;
  // `waiting` is about to wait for `empty`. Return an error to reject the wait if it would never
  // end.
  virtual Status may_wait(QueueId waiting, const std::vector<QueueId>& empty) = 0;
  // `waiting` keeps waiting for `gaps`, which have received only gaps beyond its time for long.
  // Called at most once from start to stop.
  virtual void waits_for_gap_only_pads(QueueId waiting, const std::vector<QueueId>& gaps) = 0;
  // `waiting` keeps waiting for `silent`, which have received nothing for kSilenceTimeout. Called
  // until it returns true: the user was warned.
  virtual bool waits_for_silent_pads(QueueId waiting, const std::vector<QueueId>& silent) = 0;
};

}  // namespace weir::sync
