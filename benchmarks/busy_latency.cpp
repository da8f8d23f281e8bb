// Measures the age of tensor_filter's results for each value of when-busy when a live source is
// faster than the model; prints one JSON object per line for tools/plot. The model takes 20 ms per
// frame (it only waits, so that other load on the machine matters little). A frame's age counts
// from the moment at which the source has it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using weir::gst::Ref;

constexpr double kInvokeSeconds = 0.02;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// A source pad, a tensor_filter and a sink pad; frames carry their due time.
class Stage {
 public:
  explicit Stage(const std::string& model, const std::string& when_busy) {
    const std::string line = "tensor_filter framework=gated custom=takes:" +
                             std::to_string(static_cast<int>(kInvokeSeconds * 1e6)) +
                             " model=" + model + " when-busy=" + when_busy;
    filter_ = weir::bench::launched(line);
    source_ = pad("source", GST_PAD_SRC);
    sink_ = pad("sink", GST_PAD_SINK);
    gst_pad_set_element_private(sink_.get(), this);
    gst_pad_set_chain_function(sink_.get(), on_frame);
    link(source_.get(), "sink");
    link(sink_.get(), "src");
    gst_element_set_state(filter_.get(), GST_STATE_PLAYING);
    gst_pad_push_event(source_.get(), gst_event_new_stream_start("frames"));
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(
        "other/tensor,dimension=(string)4,type=(string)float32,framerate=(fraction)0/1"));
    gst_pad_push_event(source_.get(), gst_event_new_caps(caps.get()));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(source_.get(), gst_event_new_segment(&segment));
  }
  ~Stage() {
    gst_element_set_state(filter_.get(), GST_STATE_NULL);
    gst_pad_set_active(source_.get(), FALSE);
    gst_pad_set_active(sink_.get(), FALSE);
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  // Returns the ages of the results in seconds, in ascending order, for `count` frames every
  // `period` seconds. When the source blocks, its frames get older.
  std::vector<double> ages(int count, double period) {
    begin_ = Clock::now();
    for (int i = 0; i < count; ++i) {
      const double due = i * period;
      std::this_thread::sleep_until(
          begin_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(due)));
      GstBuffer* buffer = gst_buffer_new_allocate(nullptr, 16, nullptr);
      gst_buffer_memset(buffer, 0, 0, 16);
      GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(due * GST_SECOND);
      gst_pad_push(source_.get(), buffer);
    }
    const weir::gst::Unique<GstQuery, gst_query_unref> drain(gst_query_new_drain());
    gst_pad_peer_query(source_.get(), drain.get());
    std::lock_guard lock(mutex_);
    std::sort(ages_.begin(), ages_.end());
    return ages_;
  }

 private:
  static Ref<GstPad> pad(const char* name, GstPadDirection direction) {
    auto made = Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new(name, direction))));
    gst_pad_set_active(made.get(), TRUE);
    return made;
  }
  void link(GstPad* pad, const char* name) {
    const auto other = Ref<GstPad>::adopt(gst_element_get_static_pad(filter_.get(), name));
    GST_PAD_IS_SRC(pad) ? gst_pad_link(pad, other.get()) : gst_pad_link(other.get(), pad);
  }
  static GstFlowReturn on_frame(GstPad* pad, GstObject*, GstBuffer* buffer) {
    auto* self = static_cast<Stage*>(gst_pad_get_element_private(pad));
    const double due = static_cast<double>(GST_BUFFER_PTS(buffer)) / GST_SECOND;
    gst_buffer_unref(buffer);
    std::lock_guard lock(self->mutex_);
    self->ages_.push_back(seconds_since(self->begin_) - due);
    return GST_FLOW_OK;
  }

  Ref<GstElement> filter_;
  Ref<GstPad> source_, sink_;
  Clock::time_point begin_;
  std::mutex mutex_;  // guards ages_
  std::vector<double> ages_;
};

void print(const std::string& when_busy, const char* name, double load, double age) {
  std::printf("{\"series\": \"%s %s\", \"axis\": \"load\", \"x\": %g, \"ms\": %.4f}\n",
              when_busy.c_str(), name, load, age * 1e3);
  std::fflush(stdout);
}

}  // namespace

// Usage: busy_latency MODEL [SECONDS]; any file works as MODEL.
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc < 2) return 2;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 3;
  for (const char* when_busy : {"block", "drop-new", "drop-old"})
    for (const double load : {0.25, 0.5, 0.75, 1.25, 1.5, 2.0, 4.0}) {
      const double period = kInvokeSeconds / load;
      const auto ages = Stage(argv[1], when_busy).ages(static_cast<int>(seconds / period), period);
      if (ages.empty()) return 1;
      print(when_busy, "p50", load, ages[ages.size() / 2]);
      print(when_busy, "p99", load, ages[ages.size() * 99 / 100]);
    }
}
