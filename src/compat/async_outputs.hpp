// AsyncOutputs: outputs that a filter sends by nnstreamer_filter_dispatch_output_async().
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "compat/outputs.hpp"
#include "core/timer/idle_watch.hpp"
#include "weir/engine.hpp"

namespace weir::compat {

// Owned by its filter, whose threads may call it until it is closed. A filter does not mark the
// last output of a frame. So a frame stays open until the next one begins or no output has arrived
// for a while: a short time if all outputs so far were dispatched within invoke, kQuiet for a
// filter that dispatches later from its own threads. An output that arrives without an open frame
// cannot be used, and fails the next frame.
class AsyncOutputs {
 public:
  static constexpr std::chrono::milliseconds kQuiet{2000}, kQuietWithin{100};

  // `outputs`: the number of tensors that Weir expects; 0: as many as the filter gives. `limit`:
  // how long the filter may be silent; zero: forever.
  AsyncOutputs(OpenFilter& filter, bool gives, size_t outputs, std::chrono::milliseconds limit);
  ~AsyncOutputs();
  AsyncOutputs(const AsyncOutputs&) = delete;
  AsyncOutputs& operator=(const AsyncOutputs&) = delete;

  // Ends the previous frame and opens that of `request`; this thread calls invoke next. Throws the
  // error of an output that arrived too late.
  void begin(Request& request);
  // Report the end of invoke: it returned, or failed, which ends the frame with the error.
  void invoked();
  void failed(const Error& error);

 private:
  static int dispatched(GstTensorMemory* output, GstTensorsInfo*, void* self);
  void dispatch(GstTensorMemory* output);
  void give_on(GstTensorMemory* output, const Described& now,
               const std::shared_ptr<OpenFilter>& filter);
  bool quiet(bool within);
  bool dispatches_only_within() const noexcept { return dispatched_within_ && !dispatched_later_; }
  void end();

  OpenFilter& filter_;
  const bool gives_;  // takes ownership of the outputs' memory
  const size_t outputs_;
  const std::chrono::milliseconds short_limit_, long_limit_;
  std::mutex mutex_;  // guards the members below
  std::optional<Request> request_;
  std::thread::id invoking_;  // thread of the running invoke, or none
  bool dispatched_within_ = false, dispatched_later_ = false;
  std::optional<Error> too_late_;
  std::optional<IdleWatch> short_watch_, long_watch_;  // last: destroyed first
};

}  // namespace weir::compat
