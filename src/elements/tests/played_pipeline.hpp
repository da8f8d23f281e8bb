// A whole pipeline in a test: played to its end, with every wait bounded, and what its tensor_sinks
// saw.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "element_harness.hpp"

namespace weir::test {

constexpr GstClockTime kPatience = 60 * GST_SECOND;  // nothing takes so long: it hangs

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
  // Only when the pipeline has ended or stands still.
  template <class T>
  std::vector<std::vector<T>> seen(const char* name) const {
    std::vector<std::vector<T>> all;
    for (const auto& frame : frames_.at(name)) all.push_back(values<T>(frame.get()));
    return all;
  }

  // Whether a state is reached, in time.
  bool reaches(GstState state) const {
    if (gst_element_set_state(get(), state) == GST_STATE_CHANGE_FAILURE) return false;
    const auto change = gst_element_get_state(get(), nullptr, nullptr, kPatience);
    return change == GST_STATE_CHANGE_SUCCESS || change == GST_STATE_CHANGE_NO_PREROLL;
  }
  // The first error; "" when the stream ended, "hangs" when neither came.
  std::string outcome() const {
    const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
        bus_.get(), kPatience, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
    if (!message) return "hangs";
    return GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS ? "" : text_of(message.get());
  }
  std::string plays_to_its_end() const {
    gst_element_set_state(get(), GST_STATE_PLAYING);
    return outcome();
  }

 private:
  using Frames = std::vector<Ref<GstBuffer>>;
  std::map<std::string, Frames> frames_;  // before the elements that add to them
  Ref<GstElement> element_;
  Ref<GstBus> bus_;
};

// What a pipeline says that is played to its end: "" or the error; "not linked: ..." of one that is
// none.
inline std::string error_of_pipeline(const std::string& launch) {
  GError* raw = nullptr;
  const Unique<GstElement, gst_object_unref> parsed(gst_parse_launch(launch.c_str(), &raw));
  const Unique<GError, g_error_free> unlinked(raw);
  if (unlinked) return std::string("not linked: ") + unlinked->message;
  return PlayedPipeline(launch).plays_to_its_end();
}

}  // namespace weir::test
