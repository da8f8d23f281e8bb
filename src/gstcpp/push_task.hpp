// PushTask: a task on a source pad that pushes what other threads have made ready.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <condition_variable>
#include <functional>
#include <mutex>

namespace weir::gst {

// wake(), stop() and join() may be called from any thread but the task's.
class PushTask {
 public:
  // `source` is borrowed; `push` runs on the task, one call at a time, and must not throw.
  void set(GstPad* source, std::function<void()> push);

  // Before the pads are activated.
  void open();
  // Has `push` called once more, soon. The first call starts the task. Nothing happens when closed.
  void wake();
  // Before the pads are deactivated: the task ends when the push that goes on does.
  void close();
  // After the pads were deactivated: waits until the task has ended.
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
