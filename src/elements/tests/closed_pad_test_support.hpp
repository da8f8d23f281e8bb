// ClosedPad: a pad that blocks each buffer, and the thread that pushes it, until it is opened.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <condition_variable>
#include <mutex>

#include "gstcpp/element/ref.hpp"

namespace weir::test {

class ClosedPad {
 public:
  explicit ClosedPad(GstPad* pad) : pad_(gst::Ref<GstPad>::share(pad)) {
    id_ = gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, hold, this, nullptr);
  }
  ClosedPad(const ClosedPad&) = delete;
  ClosedPad& operator=(const ClosedPad&) = delete;
  ~ClosedPad() {
    open();
    gst_pad_remove_probe(pad_.get(), id_);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return inside_ == 0; });
  }
  void wait_until_one_is_held() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return came_; });
  }
  void open() {
    std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

 private:
  static GstPadProbeReturn hold(GstPad*, GstPadProbeInfo*, gpointer data) {
    auto* self = static_cast<ClosedPad*>(data);
    std::unique_lock lock(self->mutex_);
    self->came_ = true;
    ++self->inside_;
    self->changed_.notify_all();
    self->changed_.wait(lock, [self] { return self->open_; });
    --self->inside_;
    self->changed_.notify_all();
    return GST_PAD_PROBE_OK;
  }
  const gst::Ref<GstPad> pad_;
  gulong id_ = 0;
  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  bool came_ = false, open_ = false;
  int inside_ = 0;
};

}  // namespace weir::test
