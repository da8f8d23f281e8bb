// edgesrc with protocol=local: edgesinks that come and go, and elements downstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edge_local_test_support.hpp"
#include "transport/local/publisher.hpp"

namespace edgesrc_test {

using namespace weir::test;

using EdgeLocalSource = EdgeLocal;

TEST_F(EdgeLocalSource, AReceiverGetsTheNextEdgesinkToo) {
  auto out = sink();
  const auto in = source("reconnect=true");
  for (uint8_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(receivers_become(out, 1));
    gst_harness_push(out.get(), frame(Bytes{i, i, i, i}));
    const auto got = pull(in);
    ASSERT_TRUE(got);
    EXPECT_EQ(content(got.get()), Bytes(4, i));
    EXPECT_TRUE(GST_BUFFER_FLAG_IS_SET(got.get(), GST_BUFFER_FLAG_DISCONT));
    out.reset();
    out = sink();
  }
  EXPECT_TRUE(wait_for_stat(in, "edgesrc", "reconnections", 3));
}

TEST_F(EdgeLocalSource, WithoutReconnectALostEdgesinkIsAnError) {
  auto out = sink();
  const auto in = source();
  Errors errors(in);
  out.reset();
  std::string error;
  ASSERT_TRUE(becomes_true([&] { return !(error = errors.next()).empty(); }, "the error"));
  EXPECT_SAYS(error, "the edgesink has closed the connection");
  EXPECT_SAYS(error, folder_);
  EXPECT_SAYS(error, "reconnect=true");
}

TEST_F(EdgeLocalSource, AnElementThatWritesGetsACopy) {
  const auto out = sink();
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  auto got = pull(in);
  auto own = Ref<GstBuffer>::adopt(gst_buffer_make_writable(got.release()));
  GstMapInfo info;
  ASSERT_TRUE(gst_buffer_map(own.get(), &info, GST_MAP_READWRITE));
  info.data[0] = 99;
  gst_buffer_unmap(own.get(), &info);
  EXPECT_EQ(content(own.get()), (Bytes{99, 2, 3, 4}));
}

TEST_F(EdgeLocalSource, DoTimestampReplacesTheTimeOfTheSender) {
  const auto out = sink();
  const auto in = source("do-timestamp=true");
  ASSERT_TRUE(receivers_become(out, 1));
  for (int i = 0; i < 2; ++i) {
    gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}, 1000 * GST_SECOND));
    const auto got = pull(in);
    ASSERT_TRUE(got);
    EXPECT_LT(GST_BUFFER_PTS(got.get()), 1000 * GST_SECOND);
  }
}

TEST_F(EdgeLocalSource, DeprecatedPropertiesOfEdgesrcWarn) {
  const auto out = sink();
  const auto element = lone_element("edgesrc host=somewhere" + ends_with());
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  EXPECT_SAYS(errors.next_warning(), "host and port of edgesrc have no effect");
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST_F(EdgeLocalSource, DownstreamThatTakesOtherCapsIsNamed) {
  const auto out = sink();
  const auto pipeline = lone_element("edgesrc" + ends_with() + "! video/x-raw ! fakesink");
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const auto message = Ref<GstMessage>::adopt(
      gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND, GST_MESSAGE_ERROR));
  EXPECT_SAYS(get_text(message.get()), "does not accept its output");
  EXPECT_SAYS(get_text(message.get()), "video/x-raw");
  EXPECT_SAYS(get_text(message.get()), "fix: other/tensors,format=static,dimensions=(string)");
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

// As filesink does, which collects 64 KiB before it writes.
TEST_F(EdgeLocalSource, ElementsThatKeepAllBuffersGetCopies) {
  const auto out = sink("max-buffers=3");
  const auto in = source();
  ASSERT_TRUE(receivers_become(out, 1));
  std::vector<Ref<GstBuffer>> kept;
  for (uint8_t i = 0; i < 20; ++i) {
    gst_harness_push(out.get(), frame(Bytes{i, 0, 0, 0}));
    kept.push_back(pull(in));
  }
  for (uint8_t i = 0; i < 20; ++i) EXPECT_EQ(content(kept[i].get()), (Bytes{i, 0, 0, 0}));
  EXPECT_EQ(stat(in, "edgesrc", "bytes-copied"), 18u * 4);
  kept.clear();
  gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4}));
  EXPECT_TRUE(pull(in));
  EXPECT_EQ(stat(in, "edgesrc", "bytes-copied"), 18u * 4);
}

class HostileEdgesink : public EdgeLocal {
 protected:
  // The error of an edgesrc that gets these caps from a process of the same user.
  std::string error_of_caps(const std::string& text) {
    const auto writer = weir::local::Publisher::open({.path = path(), .refused = {}});
    EXPECT_TRUE(writer);
    EXPECT_TRUE((*writer)->set_caps(text));
    const auto element = lone_element("edgesrc" + ends_with() + "! fakesink");
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(element.get()));
    gst_element_set_state(element.get(), GST_STATE_PLAYING);
    const auto message = Ref<GstMessage>::adopt(
        gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND, GST_MESSAGE_ERROR));
    const std::string text_of_error = message ? get_text(message.get()) : "hangs";
    gst_element_set_state(element.get(), GST_STATE_NULL);
    return text_of_error;
  }
};

TEST_F(HostileEdgesink, CapsThatWouldOverflowTheStackAreRefused) {
  const std::string error = error_of_caps("video/x-raw,a=" + std::string(30000, '{'));
  EXPECT_SAYS(error, "WEIR-6004: the edgesink of a local stream sent an invalid message");
  EXPECT_SAYS(error, "not at most 16 lists or structures in each other");
}

TEST_F(HostileEdgesink, CapsThatAreNotFixedAreNamedWithoutControlCharacters) {
  const std::string error = error_of_caps("video/x-raw,a=\"\x1b[2J\x07\",width=[1,2]");
  EXPECT_SAYS(error, "caps that are not fixed");
  EXPECT_SAYS(error, "\\x1b[2J\\x07");
  EXPECT_EQ(error.find('\x1b'), std::string::npos);
}

}  // namespace edgesrc_test
