// Stage: a stream for benchmarks, appsrc ! ELEMENTS ! fakesink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"

namespace weir::bench {

using gst::Ref;

class Stage {
 public:
  // `ahead`: frames queued in advance; with as many as a run has, the source never blocks.
  Stage(const std::string& caps, size_t bytes, const std::string& between, int ahead = 64) {
    const std::string launch =
        "appsrc name=in format=time block=true max-buffers=" + std::to_string(ahead) +
        " max-bytes=0 caps=\"" + caps + "\" ! " + between +
        " ! fakesink name=out async=false signal-handoffs=true";
    pipeline_ = launched(launch);
    in_ = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "in"));
    const auto out = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "out"));
    g_signal_connect(out.get(), "handoff", G_CALLBACK(on_frame), this);
    buffer_ = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, bytes, nullptr));
    gst_buffer_memset(buffer_.get(), 0, 0, bytes);
    if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
      fail();
  }
  ~Stage() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  void run(int frames) {
    wanted_ = frames;
    for (int i = 0; i < frames; ++i)
      gst_app_src_push_buffer(GST_APP_SRC(in_.get()), gst_buffer_copy(buffer_.get()));
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return wanted_ == 0; });
  }

 protected:
  Ref<GstElement> pipeline_;

 private:
  // A stage that cannot play would wait for its frames forever.
  [[noreturn]] void fail() {
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
    GstMessage* message = gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR);
    GError* error = nullptr;
    if (message) gst_message_parse_error(message, &error, nullptr);
    std::fprintf(stderr, "%s\n", error ? error->message : "the pipeline does not play");
    std::exit(1);
  }
  static void on_frame(GstElement*, GstBuffer*, GstPad*, Stage* self) {
    std::lock_guard lock(self->mutex_);
    if (--self->wanted_ == 0) self->done_.notify_one();
  }
  Ref<GstElement> in_;
  Ref<GstBuffer> buffer_;
  std::mutex mutex_;
  std::condition_variable done_;
  int wanted_ = 0;  // guarded by mutex_ while frames are in flight
};

}  // namespace weir::bench
