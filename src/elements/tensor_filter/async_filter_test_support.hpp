// A tensor_filter invoke-async=true in a harness; the engine is tests/support/async_engine.cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <string>

#include "becomes.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir::test::async {

inline constexpr char kFilter[] = "tensor_filter";
inline const std::string kFour = tensors("float32", "4:1");

inline std::string filter(const std::string& custom, const std::string& properties = "") {
  const std::string path = testing::TempDir() + "weir_async_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=fake-async invoke-async=true model=" + path +
         (custom.empty() ? "" : " custom=" + custom) + " " + properties;
}
inline Harness harness(const std::string& custom, const std::string& properties = "") {
  return make_harness(filter(custom, properties), kFour);
}
inline GstFlowReturn push(const Harness& h, float value, GstClockTime time = GST_CLOCK_TIME_NONE) {
  return gst_harness_push(h.get(), frame<float>({value, value, value, value}, time));
}
// Waits for the next output and returns its first number.
inline float pull(const Harness& h) {
  const auto b = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  return b ? values<float>(b.get())[0] : -1;
}
// Waits until EOS and everything before it have been received.
class End {
 public:
  explicit End(const Harness& h) {
    gst_pad_add_probe(h->sinkpad, GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, note, this, nullptr);
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return came_; });
  }

 private:
  static GstPadProbeReturn note(GstPad*, GstPadProbeInfo* info, gpointer data) {
    if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) != GST_EVENT_EOS) return GST_PAD_PROBE_OK;
    auto* self = static_cast<End*>(data);
    std::lock_guard lock(self->mutex_);
    self->came_ = true;
    self->changed_.notify_all();
    return GST_PAD_PROBE_OK;
  }
  std::mutex mutex_;  // guards came_
  std::condition_variable changed_;
  bool came_ = false;
};
inline void flush(const Harness& h) {
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
}
// Waits for the next error.
inline std::string await(Errors& errors) {
  std::string text;
  EXPECT_TRUE(becomes_true([&] { return !(text = errors.next()).empty(); }, "an error"));
  return text;
}
// If frames time out, the error of the first one is posted before the last one is counted.
inline void expect_sums(const Harness& h) {
  wait_for_stat(h, kFilter, "held", 0);
  EXPECT_EQ(stat(h, kFilter, "received"),
            stat(h, kFilter, "consumed") + stat(h, kFilter, "dropped"));
}

}  // namespace weir::test::async
