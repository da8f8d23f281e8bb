// Answers of a query server and the requests that they belong to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/pending_requests.hpp"

#include <gtest/gtest.h>

namespace weir::edge {
namespace {

using Strings = std::vector<std::string>;
using Requests = PendingRequests<std::string>;

// A time of the test's own clock, in milliseconds.
std::chrono::steady_clock::time_point at(int ms) {
  return std::chrono::steady_clock::time_point(std::chrono::milliseconds(ms));
}

// The frame of an answer; "late" for an answer that came too late, "error: ..." for an error.
std::string frame_of(Requests& requests, std::optional<uint64_t> number = {}) {
  auto frame = requests.accept(number);
  if (!frame) return "error: " + frame.error().what + ": " + frame.error().offered;
  return frame->value_or("late");
}

TEST(PendingRequests, MatchesTheNthAnswerWithTheNthRequest) {
  Requests requests(8);
  for (const char* name : {"a", "b", "c"}) requests.add(name, {});
  EXPECT_EQ(frame_of(requests), "a");
  EXPECT_EQ(frame_of(requests), "b");
  EXPECT_EQ(requests.waiting(), 1u);
  EXPECT_EQ(frame_of(requests), "c");
}

TEST(PendingRequests, HasRoomForOneMoreThanMaxRequest) {
  Requests requests(2);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(requests.has_room()) << i;
    requests.add("a", {});
  }
  EXPECT_FALSE(requests.has_room());
  frame_of(requests);
  EXPECT_TRUE(requests.has_room());
}

TEST(PendingRequests, ATimeOutFreesItsPlaceAndKeepsTheOrder) {
  Requests requests(1);
  requests.add("a", at(10));
  requests.add("b", at(30));
  EXPECT_FALSE(requests.has_room());
  EXPECT_EQ(requests.next_deadline(), at(10));
  EXPECT_EQ(requests.expire(at(9)), Strings{});
  EXPECT_EQ(requests.expire(at(10)), Strings{"a"});
  EXPECT_EQ(requests.expire(at(11)), Strings{});  // once
  EXPECT_TRUE(requests.has_room());
  EXPECT_EQ(requests.next_deadline(), at(30));
  requests.add("c", {});
  EXPECT_EQ(frame_of(requests), "late");
  EXPECT_EQ(frame_of(requests), "b");
  EXPECT_EQ(frame_of(requests), "c");
  EXPECT_FALSE(requests.next_deadline());
}

TEST(PendingRequests, ReconnectsWhenMoreThanMaxRequestAreWithoutAnAnswer) {
  Requests requests(1);
  for (const char* name : {"a", "b"}) {
    EXPECT_FALSE(requests.must_reconnect()) << name;
    requests.add(name, at(10));
    requests.expire(at(10));
  }
  EXPECT_TRUE(requests.must_reconnect());
  requests.add("c", {});
  EXPECT_EQ(requests.clear(), Strings{"c"});
  EXPECT_FALSE(requests.must_reconnect());
  requests.add("d", {});
  EXPECT_EQ(frame_of(requests), "d");
}

TEST(PendingRequests, FollowsTheNumbersOfAServerThatDropsOrReordersFrames) {
  Requests requests(8);
  const auto a = requests.add("a", {});
  requests.add("b", at(10));
  const auto c = requests.add("c", {});
  EXPECT_EQ(frame_of(requests, c), "c");
  EXPECT_EQ(frame_of(requests, a), "a");
  EXPECT_EQ(requests.expire(at(10)), Strings{"b"});
  EXPECT_EQ(frame_of(requests, 1), "late");
  EXPECT_FALSE(requests.must_reconnect());
}

TEST(PendingRequests, NeverReconnectsForLostAnswersOfAServerThatRepeatsNumbers) {
  Requests requests(0);
  EXPECT_EQ(frame_of(requests, requests.add("a", {})), "a");
  for (int i = 0; i < 3; ++i) {
    requests.add("b", at(10));
    requests.expire(at(10));
    EXPECT_FALSE(requests.must_reconnect()) << i;
    EXPECT_TRUE(requests.has_room()) << i;
  }
}

TEST(PendingRequests, RefusesAnAnswerWithoutARequest) {
  Requests requests(8);
  EXPECT_EQ(frame_of(requests),
            "error: an answer belongs to no request: one answer more than requests");
  requests.add("a", {});
  EXPECT_EQ(frame_of(requests), "a");
  EXPECT_EQ(requests.accept({}).error().code, Code::PEER_MESSAGE_INVALID);
}

TEST(PendingRequests, RefusesANumberThatWasNotSentOnTheConnection) {
  Requests requests(8);
  const auto old = requests.add("a", {});
  EXPECT_EQ(frame_of(requests, 7), "error: an answer belongs to no request: weir.seq 7");
  requests.clear();
  requests.add("b", {});
  EXPECT_EQ(frame_of(requests, old), "error: an answer belongs to no request: weir.seq 0");
  EXPECT_EQ(requests.waiting(), 1u);
}

TEST(PendingRequests, RefusesAnAnswerWithoutANumberAfterNumberedOnes) {
  Requests requests(8);
  const auto a = requests.add("a", {});
  requests.add("b", {});
  EXPECT_EQ(frame_of(requests, a), "a");
  EXPECT_EQ(frame_of(requests), "error: an answer has no weir.seq: an answer without a number");
}

TEST(PendingRequests, ANumberedAnswerThatComesTwiceIsGivenToNoOtherRequest) {
  Requests requests(8);
  const auto a = requests.add("a", {});
  requests.add("b", {});
  EXPECT_EQ(frame_of(requests, a), "a");
  EXPECT_EQ(frame_of(requests, a), "late");
  EXPECT_EQ(requests.waiting(), 1u);
}

}  // namespace
}  // namespace weir::edge
