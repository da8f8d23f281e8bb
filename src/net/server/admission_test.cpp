// How much each peer may have at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "net/server/admission.hpp"
#include "says.hpp"

namespace weir::net {
namespace admission_test {

// Calls of peers. `started_` has those whose request may be received.
class Admitting : public ::testing::Test {
 protected:
  // Returns why it is refused; "" = admitted.
  std::string enter(const std::string& peer, int call = 0, CallKind kind = CallKind::Request) {
    auto why = admission_->enter(peer, kind);
    if (!why) {
      why = admission_->read(peer, &calls_[call], [this, call] { started_.push_back(call); });
      if (why) admission_->leave(peer, kind);
    }
    return why.value_or("");
  }
  void leave(const std::string& peer, uint64_t bytes = 0, CallKind kind = CallKind::Request) {
    admission_->release(peer, bytes);
    admission_->leave(peer, kind);
  }
  void limit(const AdmissionLimits& limits) { admission_.emplace(limits); }

  std::optional<Admission> admission_;
  std::vector<int> started_;
  std::array<char, 16> calls_{};  // their addresses are the calls
};

TEST_F(Admitting, CountsTheNetworkOfAnIPv6Address) {
  limit({.address_connections = 2});
  EXPECT_EQ(enter("ipv6:%5B2001:db8:0:1::1%5D:1"), "");
  EXPECT_EQ(enter("ipv6:%5B2001:db8:0:1:2::3%5D:1"), "");
  EXPECT_SAYS(enter("ipv6:%5B2001:db8:0:1:ffff::%5D:1"), "max-connections-per-address");
  EXPECT_EQ(enter("ipv6:%5B2001:db8:0:2::1%5D:1"), "");
}

TEST_F(Admitting, LimitsRequestsAndConnections) {
  limit({.requests = 2, .connections = 2, .address_connections = 0});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  EXPECT_SAYS(enter("ipv4:1.1.1.1:1"), "2 requests in progress (max-requests)");
  EXPECT_EQ(enter("ipv4:1.1.1.1:2"), "");
  EXPECT_SAYS(enter("ipv4:1.1.1.2:1"), "2 connections at a time (max-connections)");
  leave("ipv4:1.1.1.1:2");
  EXPECT_EQ(enter("ipv4:1.1.1.2:1"), "");
  leave("ipv4:1.1.1.1:1");
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  EXPECT_EQ(admission_->refused(), 2u);
}

TEST_F(Admitting, LimitsTheConnectionsOfAnAddress) {
  limit({.address_connections = 2});
  for (const auto* address : {"ipv4:1.1.1.1:", "ipv6:%5B::1%5D:"}) {
    const std::string peer = address;
    EXPECT_EQ(enter(peer + "1"), "");
    EXPECT_EQ(enter(peer + "2"), "");
    EXPECT_SAYS(enter(peer + "3"),
                "this address has 2 connections with requests in progress "
                "(max-connections-per-address)");
    EXPECT_EQ(enter(peer + "2"), "");
  }
  leave("ipv4:1.1.1.1:1");
  EXPECT_EQ(enter("ipv4:1.1.1.1:3"), "");
}

TEST_F(Admitting, LimitsNothingOnAUnixSocketNorWithZeros) {
  limit({.requests = 1, .connections = 1, .address_bytes = 1, .message_bytes = 1});
  for (int i = 0; i < 16; ++i) EXPECT_EQ(enter("unix:/run/weir", i), "");
  EXPECT_EQ(started_.size(), 16u);
  limit({.requests = 0, .connections = 0, .address_connections = 0, .address_bytes = 0});
  for (int i = 0; i < 100; ++i) EXPECT_EQ(enter("ipv4:1.1.1.1:" + std::to_string(i % 50)), "");
  EXPECT_EQ(started_.size(), 116u);
}

TEST_F(Admitting, LetsAsManyRequestsComeInAsTheLargestMessagesHaveRoom) {
  limit({.address_bytes = 250, .message_bytes = 100});
  for (int i = 0; i < 4; ++i) EXPECT_EQ(enter("ipv4:1.1.1.1:1", i), "");
  EXPECT_EQ(started_, (std::vector<int>{0, 1}));
  EXPECT_EQ(enter("ipv4:2.2.2.2:1", 9), "");  // another address has room of its own
  EXPECT_EQ(started_, (std::vector<int>{0, 1, 9}));
  admission_->received("ipv4:1.1.1.1:1", 10);  // 10 + 100 are taken
  EXPECT_EQ(started_, (std::vector<int>{0, 1, 9, 2}));
  admission_->received("ipv4:1.1.1.1:1", 100);  // 110 + 100
  EXPECT_EQ(started_.size(), 4u);
  leave("ipv4:1.1.1.1:1", 100);
  EXPECT_EQ(started_, (std::vector<int>{0, 1, 9, 2, 3}));
}

TEST_F(Admitting, RefusesWhenReceivedRequestsLeaveNoRoom) {
  limit({.address_bytes = 3u << 20, .message_bytes = 2u << 20});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  admission_->received("ipv4:1.1.1.1:1", (3u << 20) / 2);
  EXPECT_SAYS(enter("ipv4:1.1.1.1:1"),
              "the requests in progress of this address have 1 MiB, so the server cannot accept "
              "another one of up to 2 MiB (max-bytes-in-flight)");
  leave("ipv4:1.1.1.1:1", (3u << 20) / 2);
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  EXPECT_EQ(admission_->refused(), 1u);
}

TEST_F(Admitting, AdmitsOneMessageThatIsLargerThanTheLimit) {
  limit({.address_bytes = 1, .message_bytes = 100});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 1), "");
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 2), "");
  EXPECT_EQ(started_, (std::vector<int>{1}));
  admission_->received("ipv4:1.1.1.1:1", 0);
  leave("ipv4:1.1.1.1:1");
  EXPECT_EQ(started_, (std::vector<int>{1, 2}));
}

TEST_F(Admitting, ForgetsCallsThatWaitAndNoOthers) {
  limit({.address_bytes = 100, .message_bytes = 100});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 1), "");
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 2), "");
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 3), "");
  EXPECT_FALSE(admission_->forget("ipv4:1.1.1.1:1", &calls_[1]));
  EXPECT_TRUE(admission_->forget("ipv4:1.1.1.1:1", &calls_[2]));
  EXPECT_FALSE(admission_->forget("ipv4:1.1.1.1:1", &calls_[2]));
  EXPECT_FALSE(admission_->forget("ipv4:9.9.9.9:1", &calls_[2]));
  leave("ipv4:1.1.1.1:1");
  admission_->received("ipv4:1.1.1.1:1", 0);
  EXPECT_EQ(started_, (std::vector<int>{1, 3}));
}

TEST_F(Admitting, CountsStreamsApartFromRequests) {
  limit({.requests = 1, .streams = 2});
  const std::string peer = "ipv4:1.1.1.1:1";
  EXPECT_EQ(enter(peer), "");
  EXPECT_EQ(enter(peer, 1, CallKind::Stream), "");
  EXPECT_EQ(enter(peer, 2, CallKind::Stream), "");
  EXPECT_SAYS(enter(peer, 3, CallKind::Stream), "this connection has 2 streams");
  EXPECT_SAYS(enter(peer), "1 requests in progress");
  leave(peer, 0, CallKind::Stream);
  EXPECT_EQ(enter(peer, 3, CallKind::Stream), "");
}

TEST_F(Admitting, CountsAConnectionUntilItsLastStreamEnds) {
  limit({.connections = 1});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 0, CallKind::Stream), "");
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  leave("ipv4:1.1.1.1:1");
  EXPECT_SAYS(enter("ipv4:1.1.1.2:1"), "1 connections at a time");
  leave("ipv4:1.1.1.1:1", 0, CallKind::Stream);
  EXPECT_EQ(enter("ipv4:1.1.1.2:1"), "");
}

// A stream may end while a message is received.
TEST_F(Admitting, GivesRoomBackWhenAMessageComesAfterTheEnd) {
  limit({.address_bytes = 100, .message_bytes = 100});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 1, CallKind::Stream), "");
  leave("ipv4:1.1.1.1:1", 0, CallKind::Stream);
  EXPECT_EQ(enter("ipv4:1.1.1.1:2", 2), "");
  EXPECT_EQ(started_, (std::vector<int>{1}));
  admission_->received("ipv4:1.1.1.1:1", 50);
  EXPECT_EQ(started_, (std::vector<int>{1}));
  admission_->release("ipv4:1.1.1.1:1", 50);
  EXPECT_EQ(started_, (std::vector<int>{1, 2}));
}

TEST_F(Admitting, CountsAConnectionUntilItsLastResponseIsSent) {
  limit({.requests = 1, .connections = 1});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  admission_->begin_response("ipv4:1.1.1.1:1", CallKind::Request, 0);
  EXPECT_EQ(enter("ipv4:1.1.1.1:1"), "");
  admission_->begin_response("ipv4:1.1.1.1:1", CallKind::Request, 0);
  admission_->end_response("ipv4:1.1.1.1:1", 0);
  EXPECT_SAYS(enter("ipv4:1.1.1.2:1"), "1 connections at a time");
  admission_->end_response("ipv4:1.1.1.1:1", 0);
  EXPECT_EQ(enter("ipv4:1.1.1.2:1"), "");
}

TEST_F(Admitting, LetsRequestsWaitForTheRoomOfResponses) {
  limit({.address_bytes = 250, .message_bytes = 100});
  EXPECT_EQ(enter("ipv4:1.1.1.1:1", 1), "");
  admission_->received("ipv4:1.1.1.1:1", 10);
  admission_->begin_response("ipv4:1.1.1.1:1", CallKind::Request, 150);
  EXPECT_EQ(enter("ipv4:1.1.1.1:2", 2), "");
  EXPECT_EQ(enter("ipv4:2.2.2.2:1", 9), "");
  EXPECT_EQ(started_, (std::vector<int>{1, 9}));
  admission_->end_response("ipv4:1.1.1.1:1", 160);
  EXPECT_EQ(started_, (std::vector<int>{1, 9, 2}));
}

}  // namespace admission_test
}  // namespace weir::net
