// mqttsrc with messages of others that cannot be used: they are dropped, and the stream continues.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/mqtt_elements_test_support.hpp"

namespace weir::test {
namespace unusable_messages_test {

using UnusableMessages = MqttElements;

// Everyone who may publish to the topic can send such caps.
TEST_F(UnusableMessages, DropsMessagesWithCapsThatCannotBeUsed) {
  PlayedPipeline p(source("protocol=5 sub-topic=t num-buffers=2") +
                   " ! tensor_sink name=out async=false");
  p.watch("out");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client();
  const auto future = std::to_string(transport::unix_time() + 60'000'000'000);
  const auto with_caps = [&](const std::string& caps) {
    return MqttProperties{.user = {{"caps", caps}, {"base-epoch", future}, {"sent-epoch", future}}};
  };
  publish(*peer, bytes("abcd"), with_caps(""));
  publish(*peer, bytes("abcd"), with_caps("video/x-raw,a=" + std::string(60000, '{')));
  publish(*peer, bytes("abcd"), with_caps(kMqttCaps));
  const std::string unusable[] = {
      "no caps", "1video/x-raw", "video/x-raw,width=[2,1]", "video/x-raw,width=[1,2]", "ANY", ""};
  for (const auto& caps : unusable) publish(*peer, bytes("abcd"), with_caps(caps));
  publish(*peer, bytes("efgh"), with_caps(kMqttCaps));
  EXPECT_EQ(p.outcome(), "");
  EXPECT_EQ(p.seen<uint8_t>("out").size(), 2u);
  EXPECT_EQ(p.stat("source", "received"), 10u);
  EXPECT_EQ(p.stat("source", "consumed"), 2u);
  EXPECT_EQ(p.stat("source", "dropped-error"), 8u);
  EXPECT_EQ(p.stat("source", "messages-invalid"), 8u);
}

TEST_F(UnusableMessages, WarnsOnceForEachKindOfUnusableMessage) {
  PlayedPipeline p(source("sub-topic=t num-buffers=1") + " ! tensor_sink name=out async=false");
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(p.get()));
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client(MqttVersion::V311);
  const int64_t soon = transport::unix_time() + 60'000'000'000;
  for (int i = 0; i < 3; ++i) {
    publish(*peer, message_of_page("\x1b]0;title\x07\xff", soon, soon, 0));
    publish(*peer, bytes("x"));
  }
  publish(*peer, message_of_page(kMqttCaps, soon, soon, 0));
  ASSERT_TRUE(becomes_true([&] { return p.stat("source", "consumed") == 1; }, "the frame"));
  const std::string caps = take_message(bus.get(), GST_MESSAGE_WARNING);
  const std::string header = take_message(bus.get(), GST_MESSAGE_WARNING);
  EXPECT_SAYS(caps, "WEIR-6004: a message of the topic \"t\" is dropped: its caps cannot be used");
  EXPECT_SAYS(caps, "offered: \"\\x1b]0;title\\x07\\xff\"");
  EXPECT_SAYS(caps, "fix: set sub-topic to the topic of one publisher");
  EXPECT_EQ(caps.find('\x1b'), std::string::npos);
  EXPECT_SAYS(header, "WEIR-6004: a message of the topic \"t\" is dropped: ");
  EXPECT_EQ(take_message(bus.get(), GST_MESSAGE_WARNING), "");
  EXPECT_EQ(p.stat("source", "messages-invalid"), 6u);
}

// The broker sends a retained message again at each start.
TEST_F(UnusableMessages, ARetainedMessageWithUnusableCapsDoesNotEndTheStream) {
  const auto peer = client(MqttVersion::V311);
  const int64_t soon = transport::unix_time() + 60'000'000'000;
  const auto retained = message_of_page("video/x-raw,a=" + std::string(400, '{'), soon, soon, 0);
  ASSERT_TRUE(peer->publish({.topic = "t", .payload = retained, .qos = 1, .retain = true}, 30s));
  PlayedPipeline p(source("sub-topic=t num-buffers=1") + " ! tensor_sink name=out async=false");
  p.watch("out");
  for (uint64_t start = 0; start < 2; ++start) {
    ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
    ASSERT_TRUE(becomes_true([&] { return p.stat("source", "messages-invalid") == 1; },
                             "the retained message"));
    publish(*peer, message_of_page(kMqttCaps, soon, soon, 0));
    EXPECT_EQ(p.outcome(), "");
    ASSERT_TRUE(p.reaches(GST_STATE_READY));
  }
  EXPECT_EQ(p.seen<uint8_t>("out").size(), 2u);
}

}  // namespace unusable_messages_test
}  // namespace weir::test
