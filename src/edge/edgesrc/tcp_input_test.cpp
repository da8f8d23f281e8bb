// The stream of a publisher as buffers, and what a publisher that has not started looks like.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edgesrc/tcp_input.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "says.hpp"
#include "transport/edge/stream_publisher.hpp"
#include "transport/wake_event.hpp"

namespace weir {
namespace tcp_input_test {

using namespace std::chrono_literals;
using Kind = InputEvent::Kind;

constexpr char kCaps[] = "other/tensors, format=(string)flexible, framerate=(fraction)10/1";

class EdgeTcpInput : public ::testing::Test {
 protected:
  EdgeTcpInput() {
    auto publisher = edge::StreamPublisher::open(
        {.host = "localhost", .port = 0, .queue = {}, .allowed = {}, .refused = {}});
    EXPECT_TRUE(publisher);
    publisher_ = *std::move(publisher);
    auto input = TcpInput::open("localhost", publisher_->port(), 1 << 20,
                                {.connect = 60s, .greet = 5ms}, interruption_.descriptor());
    EXPECT_TRUE(input);
    input_ = *std::move(input);
    EXPECT_TRUE(becomes_true([&] { return publisher_->counts().waiting == 1; }, "the wait"));
  }
  void publish(size_t bytes) {
    const auto owner = std::make_shared<std::vector<std::byte>>(bytes);
    const auto outcome = publisher_->publish({std::span<const std::byte>(*owner)}, owner);
    EXPECT_TRUE(outcome && *outcome == edge::StreamPublisher::Outcome::Sent);
  }
  // What comes once the caps are set; before that, the publisher may be silent for 5 ms.
  Result<InputEvent> receive_after_caps() {
    auto event = input_->receive();
    return event && event->kind == Kind::Silent ? input_->receive() : std::move(event);
  }
  void expect(Kind kind) {
    const auto event = input_->receive();
    ASSERT_TRUE(event) << event.error().message();
    EXPECT_EQ(event->kind, kind);
  }
  void expect_buffer_of(size_t bytes) {
    const auto event = input_->receive();
    ASSERT_TRUE(event) << event.error().message();
    ASSERT_EQ(event->kind, Kind::Buffer);
    EXPECT_EQ(gst_buffer_get_size(event->buffer.get()), bytes);
  }

  transport::WakeEvent interruption_;
  std::unique_ptr<edge::StreamPublisher> publisher_;
  std::unique_ptr<BufferInput> input_;
};

TEST_F(EdgeTcpInput, APublisherWithoutCapsIsSilentOnce) {
  expect(Kind::Silent);
  ASSERT_TRUE(publisher_->set_caps(kCaps));
  const auto event = input_->receive();
  ASSERT_TRUE(event) << event.error().message();
  ASSERT_EQ(event->kind, Kind::Caps);
  const gst::UniqueText caps{gst_caps_to_string(event->caps.get())};
  EXPECT_STREQ(caps.get(), kCaps);
  publish(3);
  expect_buffer_of(3);
}

TEST_F(EdgeTcpInput, TheWaitForCapsCanBeInterrupted) {
  expect(Kind::Silent);
  interruption_.set();
  expect(Kind::Interrupted);
}

// With `reconnect`, edgesrc waits for the next one.
TEST_F(EdgeTcpInput, APublisherThatStopsBeforeItsCapsRefuses) {
  expect(Kind::Silent);
  publisher_.reset();
  const auto event = input_->receive();
  ASSERT_FALSE(event);
  EXPECT_EQ(event.error().code, Code::SERVER_REFUSED);
  EXPECT_SAYS(event.error().message(), "it closed the connection");
}

TEST_F(EdgeTcpInput, CapsWithRangesAreLeftToDownstream) {
  ASSERT_TRUE(publisher_->set_caps("other/tensors,framerate=[0/1,30/1]"));
  publish(5);
  const auto event = receive_after_caps();
  ASSERT_TRUE(event) << event.error().message();
  ASSERT_EQ(event->kind, Kind::Buffer);
  EXPECT_EQ(gst_buffer_get_size(event->buffer.get()), 5u);
}

TEST_F(EdgeTcpInput, CapsThatAreNoneNameThePublisher) {
  ASSERT_TRUE(publisher_->set_caps("no caps, at=all("));
  const auto event = receive_after_caps();
  ASSERT_FALSE(event);
  EXPECT_EQ(event.error().code, Code::PEER_MESSAGE_INVALID);
  EXPECT_SAYS(event.error().message(), "the caps of the edgesink are not valid");
  EXPECT_SAYS(event.error().message(), "no caps, at=all(");
}

// GStreamer's parser would recurse once for each brace.
TEST_F(EdgeTcpInput, CapsThatWouldOverflowTheStackAreRefused) {
  ASSERT_TRUE(publisher_->set_caps("video/x-raw,a=" + std::string(60000, '{')));
  const auto event = receive_after_caps();
  EXPECT_REFUSED(event, PEER_MESSAGE_INVALID, "the caps of the edgesink are not valid");
  EXPECT_SAYS(event.error().message(), "60014 bytes");
  EXPECT_SAYS(event.error().message(), "at most 16 lists or structures in each other");
  EXPECT_SAYS(event.error().message(), "at byte 31");
}

TEST_F(EdgeTcpInput, CapsThatFailAnAssertionAreRefused) {
  ASSERT_TRUE(publisher_->set_caps("video/x-raw,width=(int)[ 100, 1 ]"));
  EXPECT_REFUSED(receive_after_caps(), PEER_MESSAGE_INVALID,
                 "a range of two numbers, the smaller one first");
}

TEST_F(EdgeTcpInput, CapsOfManyLargeTensorsAreRead) {
  std::string dimensions, types;
  for (int i = 0; i < 256; ++i) {
    dimensions += "4294967295:4294967295:4294967295:4294967295:1:1:1:1:1:1:1:1:1:1:1:1,";
    types += "float64,";
  }
  ASSERT_TRUE(publisher_->set_caps(
      "other/tensors, format=(string)static, num_tensors=(int)256, dimensions=(string)\"" +
      dimensions + "\", types=(string)\"" + types + "\", framerate=(fraction)30/1"));
  const auto event = receive_after_caps();
  ASSERT_TRUE(event) << event.error().message();
  EXPECT_EQ(event->kind, Kind::Caps);
}

}  // namespace tcp_input_test
}  // namespace weir
