// AsyncAnswers: outputs that a filter hands over with nnstreamer_filter_dispatch_output_async().
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

// Owned by its filter: the filter's threads may call until it is closed. A filter does not say
// which output is the last of a frame. So a frame stays open until the next one begins, or until
// nothing has come for a while: a short one where all outputs so far were dispatched within invoke,
// kQuiet for a filter that dispatches later, from threads of its own. What comes when no frame is
// open cannot be given on, and fails the frame that comes next.
class AsyncAnswers {
 public:
  static constexpr std::chrono::milliseconds kQuiet{2000}, kQuietWithin{100};

  // `outputs`: how many tensors Weir expects of each; 0: as many as the filter says. `limit`: how
  // long the filter may say nothing; zero: as long as it takes.
  AsyncAnswers(OpenFilter& filter, bool gives, size_t outputs, std::chrono::milliseconds limit);
  ~AsyncAnswers();
  AsyncAnswers(const AsyncAnswers&) = delete;
  AsyncAnswers& operator=(const AsyncAnswers&) = delete;

  // Ends the frame before and opens that of `request`, which this thread's invoke follows. Throws
  // what came too late for a frame.
  void begin(Request& request);
  // Invoke returned, or failed: then the frame ends with the error.
  void invoked();
  void failed(const Error& error);

 private:
  static void dispatched(GstTensorMemory* output, void* self);
  void dispatch(GstTensorMemory* output);
  void give_on(GstTensorMemory* output, const Described& now,
               const std::shared_ptr<OpenFilter>& filter);
  bool quiet(bool within);
  void end();

  OpenFilter& filter_;
  const bool gives_;  // the outputs' memory is taken over
  const size_t outputs_;
  std::mutex mutex_;  // guards what follows
  std::optional<Request> request_;
  std::thread::id invoking_;  // of the invoke that runs, or none
  bool answers_within_ = false, answers_later_ = false;
  std::optional<Error> too_late_;
  std::optional<IdleWatch> short_watch_, long_watch_;  // last: they end first
};

}  // namespace weir::compat
