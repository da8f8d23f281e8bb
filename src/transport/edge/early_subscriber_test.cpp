// Subscribers that connect before the publisher knows its caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "becomes.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"
#include "transport/edge/stream_publisher.hpp"
#include "transport/edge/stream_subscriber.hpp"

namespace weir::edge {
namespace early_subscriber_test {

using namespace std::chrono_literals;
using wire::test::Bytes;
using wire::test::from_text;
using Outcome = StreamPublisher::Outcome;

constexpr char kCaps[] = "other/tensors,format=flexible";

class EarlySubscriber : public ::testing::Test {
 protected:
  EarlySubscriber() {
    auto made = StreamPublisher::open(
        {.host = "localhost", .port = 0, .queue = {}, .allowed = {}, .refused = {}});
    EXPECT_TRUE(made);
    publisher_ = *std::move(made);
  }
  // Its connection has been accepted, and it has no greeting.
  StreamSubscriber waiting() {
    const uint32_t before = publisher_->counts().waiting;
    auto made = StreamSubscriber::open("localhost", publisher_->port(), {}, 60s, -1);
    EXPECT_TRUE(made);
    EXPECT_TRUE(
        becomes_true([&] { return publisher_->counts().waiting == before + 1; }, "the wait"));
    const auto greeted = made->greet(io::deadline_in(5ms), -1);
    EXPECT_TRUE(greeted && !*greeted);
    return *std::move(made);
  }
  Outcome publish(const char* text) {
    const auto owner = std::make_shared<Bytes>(from_text(text));
    const auto outcome = publisher_->publish({std::span<const std::byte>(*owner)}, owner);
    EXPECT_TRUE(outcome);
    return outcome ? *outcome : Outcome::Missed;
  }
  static void expect_caps(StreamSubscriber* subscriber, const char* caps) {
    const auto greeted = subscriber->greet(std::nullopt, -1);
    ASSERT_TRUE(greeted && *greeted) << (greeted ? "" : greeted.error().message());
    EXPECT_EQ(subscriber->caps(), caps);
  }
  static void expect_frame(StreamSubscriber* subscriber, const char* text) {
    const auto received = subscriber->receive();
    ASSERT_TRUE(received && !received->end);
    ASSERT_EQ(received->memories.size(), 1u);
    EXPECT_EQ(wire::test::copy_of(received->memories[0].bytes()), from_text(text));
  }

  std::unique_ptr<StreamPublisher> publisher_;
};

TEST_F(EarlySubscriber, GetsTheCapsWhenTheyAreKnown) {
  auto one = waiting(), two = waiting();
  EXPECT_EQ(publisher_->counts().subscribers, 0u);
  EXPECT_FALSE(publisher_->has_subscriber());
  EXPECT_EQ(publish("a"), Outcome::NoSubscriber);
  ASSERT_TRUE(publisher_->set_caps(kCaps));
  expect_caps(&one, kCaps);
  expect_caps(&two, kCaps);
  EXPECT_TRUE(becomes_true([&] { return publisher_->counts().subscribers == 2; }, "subscribers"));
}

// The stream does not wait for the handshake.
TEST_F(EarlySubscriber, GetsTheFirstFrameAfterTheCaps) {
  auto one = waiting(), two = waiting();
  ASSERT_TRUE(publisher_->set_caps(kCaps));
  EXPECT_EQ(publish("first"), Outcome::Sent);
  EXPECT_EQ(publish("second"), Outcome::Sent);
  for (StreamSubscriber* subscriber : {&one, &two}) {
    expect_caps(subscriber, kCaps);
    expect_frame(subscriber, "first");
    expect_frame(subscriber, "second");
  }
  EXPECT_TRUE(publisher_->flush(std::nullopt));
}

TEST_F(EarlySubscriber, GetsNoCapsFromAStreamThatHasNone) {
  auto one = waiting();
  ASSERT_TRUE(publisher_->set_no_caps());
  EXPECT_EQ(publish("first"), Outcome::Sent);
  expect_caps(&one, "");
  expect_frame(&one, "first");
}

TEST_F(EarlySubscriber, KeepsTheCapsThatWereSetBefore) {
  ASSERT_TRUE(publisher_->set_caps(kCaps));
  ASSERT_TRUE(publisher_->set_no_caps());
  auto late = StreamSubscriber::connect("localhost", publisher_->port(), {});
  ASSERT_TRUE(late);
  EXPECT_EQ(late->caps(), kCaps);
}

TEST_F(EarlySubscriber, IsDisconnectedWhenThePublisherEnds) {
  auto one = waiting();
  publisher_.reset();
  EXPECT_REFUSED(one.greet(std::nullopt, -1), SERVER_REFUSED, "it closed the connection");
}

TEST_F(EarlySubscriber, MayEndWhileItWaits) {
  { const auto gone = waiting(); }
  ASSERT_TRUE(becomes_true([&] { return publisher_->counts().waiting == 0; }, "its end"));
  auto stays = waiting();
  ASSERT_TRUE(publisher_->set_caps(kCaps));
  expect_caps(&stays, kCaps);
  EXPECT_TRUE(becomes_true([&] { return publisher_->counts().subscribers == 1; }, "subscribers"));
  EXPECT_EQ(publisher_->counts().refused, 0u);
}

// docs/compatibility/edge-wire.md 10.6, class 3.
TEST_F(EarlySubscriber, IsRefusedIfItAnswersBeforeTheCaps) {
  const auto socket = connect_to("localhost", publisher_->port(), std::nullopt, -1);
  ASSERT_TRUE(socket);
  const Bytes response = wire::test::golden_host_info();
  EXPECT_EQ(send(socket->get(), response.data(), response.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(response.size()));
  EXPECT_TRUE(becomes_true([&] { return publisher_->counts().refused == 1; }, "the refusal"));
}

// Only the time between the greeting and its response is limited.
TEST(SubscriberLinkTime, TheWaitForCapsIsNotASlowHandshake) {
  int sockets[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets), 0);
  const Descriptor peer(sockets[1]);
  SubscriberLink link(Descriptor{sockets[0]}, wire::HeaderForm::Bytes2088, 1);
  link.wait_for_greeting();
  EXPECT_FALSE(link.removal_deadline({}));
  const auto before = std::chrono::steady_clock::now();
  link.queue_greeting(Bytes(2088));
  ASSERT_TRUE(link.removal_deadline({}));
  EXPECT_GE(*link.removal_deadline({}), before + 2s);
}

}  // namespace early_subscriber_test
}  // namespace weir::edge
