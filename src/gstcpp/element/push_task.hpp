// PushTask: a task on a source pad that pushes what other threads have prepared.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <condition_variable>
#include <functional>
#include <mutex>

namespace weir::gst {

// Any thread but the task's may call wake(), stop() and join().
class PushTask {
 public:
  // `source` is borrowed; `push` runs on the task, one call at a time, and must not throw.
  void set(GstPad* source, std::function<void()> push);

  // Call before the pads are activated.
  void open();
  // Schedules one more call of `push`. The first call starts the task. No effect when closed.
  void wake();
  // Call before the pads are deactivated: the task stops after the current push.
  void close();
  // Call after the pads were deactivated: waits until the task has stopped.
  void join();

 private:
  static void loop(gpointer self);

  GstPad* source_ = nullptr;
  std::function<void()> push_;
  std::mutex mutex_;  // guards the rest
  std::condition_variable woken_;
  bool open_ = false, running_ = false, work_ = false;
};

}  // namespace weir::gst
