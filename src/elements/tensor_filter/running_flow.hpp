// RunningFlow: holds the flow of one tensor_filter, which a property may replace while frames flow.
//
// A flush or a stop arrives on another thread and may meet the replacement: the new flow then gets
// it too.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <utility>

#include "elements/tensor_filter/frame_flow.hpp"

namespace weir {

// Thread-safe, except set() and replace().
class RunningFlow {
 public:
  using Flow = std::shared_ptr<FrameFlow>;

  Flow get() const {  // never null after set()
    std::lock_guard lock(mutex_);
    return flow_;
  }
  Flow operator->() const { return get(); }

  // Call without active pads.
  void set(Flow flow) {
    std::lock_guard lock(mutex_);
    flow_.swap(flow);
  }
  // Call when the pads are about to be activated.
  void start() { change(Phase::Stops, Phase::Flows)->resume(); }

  void flush() { change(Phase::Flows, Phase::Flushes)->flush(); }
  void resume() { change(Phase::Flushes, Phase::Flows)->resume(); }
  void stop() {
    {
      std::lock_guard lock(mutex_);
      phase_ = Phase::Stops;
    }
    get()->stop();
  }

  // Call on the streaming thread while no frame is in progress. `make` is called when the source
  // pad's task, of which there is one, is free for the new flow.
  template <class Make>
  void replace(Make&& make) {
    const Flow ended = get();
    ended->stop();
    ended->close();
    Flow made = make();
    std::lock_guard lock(mutex_);
    flow_ = std::move(made);
    if (phase_ == Phase::Flushes) flow_->flush();
    if (phase_ == Phase::Stops) flow_->stop();
  }

 private:
  enum class Phase { Flows, Flushes, Stops };  // a flush does not end a stop

  // Returns the flow that follows the change.
  Flow change(Phase from, Phase to) {
    std::lock_guard lock(mutex_);
    if (phase_ == from) phase_ = to;
    return flow_;
  }

  mutable std::mutex mutex_;  // guards the rest
  Flow flow_;
  Phase phase_ = Phase::Stops;
};

}  // namespace weir
