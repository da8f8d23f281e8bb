// tensor_mux downstream of GStreamer's valves and selectors that switch during playback.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <string>

#include "becomes.hpp"
#include "elements/tests/element_parts_test_support.hpp"
#include "gstcpp/pads/output_selector.hpp"

namespace weir::test {
namespace switch_test {

using gst::Ref;

std::string source(int width, int height = 1) {
  return "videotestsrc ! video/x-raw,format=GRAY8,framerate=1000/1,width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + " ! tensor_converter ! queue max-size-buffers=2 ! ";
}

class Playing {
 public:
  explicit Playing(const std::string& launch) : pipeline_(test::lone_element(launch)) {
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  ~Playing() { stop(); }
  Playing(const Playing&) = delete;
  Playing& operator=(const Playing&) = delete;

  void stop() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  Ref<GstElement> element(const char* name) const {
    return Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), name));
  }
  uint64_t stat(const char* name) const { return test::stat(element("mux").get(), name); }
  [[nodiscard]] bool more_come() const {
    const uint64_t until = stat("pushed") + 5;
    return becomes_true([&] { return stat("pushed") >= until || !error().empty(); },
                        [&] {
                          return std::to_string(until) + " frames pushed; there are " +
                                 std::to_string(stat("pushed"));
                        });
  }
  // The first error.
  const std::string& error() const {
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
    if (error_.empty()) error_ = test::take_message(bus.get(), GST_MESSAGE_ERROR);
    return error_;
  }
  // All input is accounted for, without errors.
  void expect_sums() {
    EXPECT_EQ(error(), "");
    stop();
    EXPECT_EQ(stat("held"), 0u);
    EXPECT_EQ(stat("received"), stat("consumed") + stat("dropped"));
    EXPECT_EQ(stat("dropped-error"), 0u);
  }

 private:
  Ref<GstElement> pipeline_;
  mutable std::string error_;
};

TEST(TensorMuxSwitch, AValveClosesAndOpensABranch) {
  Playing graph(
      source(4) + "mux.sink_0  " + source(8) +
      "valve name=valve ! mux.sink_1  tensor_mux name=mux max-wait=2000000 ! tensor_sink");
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(graph.more_come());
    g_object_set(graph.element("valve").get(), "drop", TRUE, nullptr);
    ASSERT_TRUE(graph.more_come());
    g_object_set(graph.element("valve").get(), "drop", FALSE, nullptr);
  }
  ASSERT_TRUE(graph.more_come());
  graph.expect_sums();
}

// The sources have different shapes: caps change during the stream. Their sizes are equal, because
// the selector may pass a buffer of the old source after the caps of the new one.
TEST(TensorMuxSwitch, AnInputSelectorChangesTheSource) {
  for (const char* mode : {"nosync", "slowest", "refresh"}) {
    Playing graph(source(4) + "mux.sink_0  " + source(8) + "in.sink_0  " + source(4, 2) +
                  "in.sink_1  input-selector name=in sync-streams=false ! mux.sink_1  tensor_mux "
                  "name=mux sync-mode=" +
                  mode + " ! tensor_sink");
    const auto selector = graph.element("in");
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(graph.more_come());
      const auto pad = Ref<GstPad>::adopt(
          gst_element_get_static_pad(selector.get(), i % 2 == 0 ? "sink_1" : "sink_0"));
      g_object_set(selector.get(), "active-pad", pad.get(), nullptr);
    }
    ASSERT_TRUE(graph.more_come());
    graph.expect_sums();
  }
}

// An output-selector feeds one pad or the other.
TEST(TensorMuxSwitch, AnOutputSelectorChangesThePad) {
  Playing graph(source(4) +
                "output-selector name=to  to.src_0 ! queue ! mux.sink_0  to.src_1 ! queue ! "
                "mux.sink_1  tensor_mux name=mux sync-mode=refresh max-wait=2000000 ! tensor_sink");
  const auto selector = graph.element("to");
  ASSERT_TRUE(
      becomes_true([&] { return graph.stat("received") > 0; }, "the first frame at tensor_mux"));
  for (int i = 0; i < 6; ++i) {
    gst::switch_output(Ref<GstPad>::adopt(
        gst_element_get_static_pad(selector.get(), i % 2 == 0 ? "src_1" : "src_0")));
    ASSERT_TRUE(graph.more_come());
  }
  graph.expect_sums();
}

}  // namespace switch_test
}  // namespace weir::test
