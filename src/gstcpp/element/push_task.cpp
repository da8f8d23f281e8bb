// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/push_task.hpp"

namespace weir::gst {

void PushTask::set(GstPad* source, std::function<void()> push) {
  source_ = source;
  push_ = std::move(push);
}

void PushTask::open() {
  std::lock_guard lock(mutex_);
  open_ = true;
  work_ = false;
}

void PushTask::wake() {
  std::lock_guard lock(mutex_);
  if (!open_) return;
  work_ = true;
  woken_.notify_one();
  if (!running_) running_ = gst_pad_start_task(source_, loop, this, nullptr);
}

void PushTask::close() {
  std::lock_guard lock(mutex_);
  open_ = false;
  woken_.notify_one();
}

void PushTask::join() {
  gst_pad_stop_task(source_);
  std::lock_guard lock(mutex_);
  running_ = false;
}

// One iteration of the task, under the pad's stream lock.
void PushTask::loop(gpointer data) {
  auto* self = static_cast<PushTask*>(data);
  {
    std::unique_lock lock(self->mutex_);
    self->woken_.wait(lock, [self] { return self->work_ || !self->open_; });
    if (!self->open_) {
      lock.unlock();
      gst_pad_pause_task(self->source_);
      return;
    }
    self->work_ = false;
  }
  self->push_();
}

}  // namespace weir::gst
