// PlayedPipeline: a whole pipeline played to EOS, with bounded waits, that records the frames of
// its tensor_sinks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "element_test_support.hpp"

namespace weir::test {

constexpr GstClockTime kTimeout = 60 * GST_SECOND;  // nothing takes that long: it hangs

class PlayedPipeline {
 public:
  explicit PlayedPipeline(const std::string& launch)
      : element_(lone_element(launch)), bus_(Ref<GstBus>::adopt(gst_element_get_bus(get()))) {}
  PlayedPipeline(const PlayedPipeline&) = delete;
  PlayedPipeline& operator=(const PlayedPipeline&) = delete;
  ~PlayedPipeline() { EXPECT_TRUE(reaches(GST_STATE_NULL)); }

  GstElement* get() const { return element_.get(); }
  Ref<GstElement> find(const char* name) const {
    return Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(get()), name));
  }
  uint64_t stat(const char* name, const char* field) const {
    return test::stat(find(name).get(), field);
  }
  // Keeps a reference to each frame of the tensor_sink `name`.
  void watch(const char* name) {
    auto& frames = frames_[name];
    frames.clear();
    g_signal_connect(find(name).get(), "new-data",
                     G_CALLBACK(+[](GstElement*, GstBuffer* b, Frames* seen) {
                       seen->push_back(Ref<GstBuffer>::share(b));
                     }),
                     &frames);
  }
  // Call only when the pipeline has ended or is paused.
  template <class T>
  std::vector<std::vector<T>> seen(const char* name) const {
    std::vector<std::vector<T>> all;
    for (const auto& frame : frames_.at(name)) all.push_back(values<T>(frame.get()));
    return all;
  }

  // Whether a state is reached in time.
  bool reaches(GstState state) const {
    if (gst_element_set_state(get(), state) == GST_STATE_CHANGE_FAILURE) return false;
    const auto change = gst_element_get_state(get(), nullptr, nullptr, kTimeout);
    return change == GST_STATE_CHANGE_SUCCESS || change == GST_STATE_CHANGE_NO_PREROLL;
  }
  // The first error; "" when the stream ended, "hangs" on a timeout.
  std::string outcome() const {
    const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
        bus_.get(), kTimeout, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
    if (!message) return "hangs";
    return GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS ? "" : get_text(message.get());
  }
  // Plays, and returns the first warning; "" if an error or the end comes first, or on a timeout.
  std::string first_warning() const {
    gst_element_set_state(get(), GST_STATE_PLAYING);
    constexpr auto kTypes =
        GstMessageType(GST_MESSAGE_WARNING | GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
    const auto message =
        Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(bus_.get(), kTimeout, kTypes));
    return message && GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_WARNING
               ? get_text(message.get())
               : "";
  }
  std::string plays_to_its_end() const {
    gst_element_set_state(get(), GST_STATE_PLAYING);
    return outcome();
  }

 private:
  using Frames = std::vector<Ref<GstBuffer>>;
  std::map<std::string, Frames> frames_;  // declared before the elements that add to it
  Ref<GstElement> element_;
  Ref<GstBus> bus_;
};

// Plays a pipeline to its end and returns "" or the error; "not linked: ..." if it cannot be
// parsed.
inline std::string error_of_pipeline(const std::string& launch) {
  GError* raw = nullptr;
  const Unique<GstElement, gst_object_unref> parsed(gst_parse_launch(launch.c_str(), &raw));
  const Unique<GError, g_error_free> unlinked(raw);
  if (unlinked) return std::string("not linked: ") + unlinked->message;
  return PlayedPipeline(launch).plays_to_its_end();
}

}  // namespace weir::test
