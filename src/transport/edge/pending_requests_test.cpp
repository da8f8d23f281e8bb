// Responses of a query server and the requests that they belong to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/pending_requests.hpp"

#include <gtest/gtest.h>

namespace weir::edge {
namespace pending_requests_test {

using Requests = PendingRequests<std::string, int>;

// A time of the test's own clock, in milliseconds.
std::chrono::steady_clock::time_point at(int ms) {
  return std::chrono::steady_clock::time_point(std::chrono::milliseconds(ms));
}

// The frames that have a response, in order; "(a)" is a late one.
std::string taken(Requests& requests) {
  std::string out;
  while (const auto next = requests.take())
    out += next->late ? "(" + next->frame + ")" : next->frame;
  return out;
}

// A response arrives; returns what can be taken, or the error.
std::string after_response(Requests& requests, std::optional<uint64_t> number = {}) {
  if (const auto status = requests.accept(number, 1); !status)
    return "error: " + status.error().what + ": " + status.error().offered;
  return taken(requests);
}

void add(Requests& requests, std::initializer_list<const char*> names, io::Deadline deadline = {}) {
  for (const char* name : names) requests.add(name, deadline);
}

TEST(PendingRequests, MatchesTheNthResponseWithTheNthRequest) {
  Requests requests;
  add(requests, {"a", "b", "c"});
  EXPECT_EQ(after_response(requests), "a");
  EXPECT_EQ(after_response(requests), "b");
  EXPECT_EQ(requests.waiting(), 1u);
  EXPECT_EQ(after_response(requests), "c");
}

TEST(PendingRequests, KeepsTheResponseToEachRequest) {
  Requests requests;
  add(requests, {"a", "b"});
  ASSERT_TRUE(requests.accept({}, 7) && requests.accept({}, 8));
  EXPECT_EQ(requests.take()->response, 7);
  EXPECT_EQ(requests.take()->response, 8);
}

TEST(PendingRequests, HasRoomForOneMoreThanMaxRequest) {
  Requests requests;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(requests.has_room(2)) << i;
    add(requests, {"a"});
  }
  EXPECT_FALSE(requests.has_room(2));
  EXPECT_TRUE(requests.has_room(0));  // no limit
  after_response(requests);
  EXPECT_TRUE(requests.has_room(2));
}

TEST(PendingRequests, ATimeOutFreesItsPlaceAndKeepsTheOrder) {
  Requests requests;
  add(requests, {"a"}, at(10));
  add(requests, {"b"}, at(30));
  EXPECT_FALSE(requests.has_room(1));
  EXPECT_EQ(requests.next_deadline(), at(10));
  EXPECT_EQ(requests.expire(at(9)), 0u);
  EXPECT_EQ(requests.expire(at(10)), 1u);
  EXPECT_EQ(requests.expire(at(11)), 0u);  // once
  EXPECT_TRUE(requests.has_room(1));
  EXPECT_EQ(requests.next_deadline(), at(30));
  EXPECT_EQ(requests.add("c", {}), 1u);
  EXPECT_EQ(after_response(requests), "");  // of "a", or of "b" if the server dropped "a"
  EXPECT_EQ(after_response(requests), "b");
  EXPECT_EQ(after_response(requests), "c");
  EXPECT_FALSE(requests.next_deadline());
}

TEST(PendingRequests, ALateResponseIsUsedBeforeTheNextRequest) {
  Requests requests;
  add(requests, {"a"}, at(10));
  EXPECT_EQ(requests.expire(at(10)), 1u);
  EXPECT_EQ(after_response(requests), "(a)");
  EXPECT_EQ(requests.add("b", {}), 0u);
  EXPECT_EQ(after_response(requests), "b");
}

TEST(PendingRequests, ReconnectsAfterMoreThanMaxRequestTimeOutsInARow) {
  Requests requests;
  for (const char* name : {"a", "b"}) {
    EXPECT_FALSE(requests.must_reconnect(1)) << name;
    add(requests, {name}, at(10));
    requests.expire(at(10));
  }
  EXPECT_TRUE(requests.must_reconnect(1));
  add(requests, {"c"});
  EXPECT_EQ(requests.clear().waiting, 1u);
  EXPECT_FALSE(requests.must_reconnect(1));
  add(requests, {"d"});
  EXPECT_EQ(after_response(requests), "d");
}

// A server that dropped one frame: each response is discarded for the request before its own.
TEST(PendingRequests, ReconnectsWhenEachResponseIsTakenForTheOneBefore) {
  Requests requests;
  int sent = 0;
  for (; sent < 10 && !requests.must_reconnect(2); ++sent) {
    add(requests, {"a"}, at(sent));
    if (sent > 0) {
      EXPECT_EQ(after_response(requests), "");
    }
    requests.expire(at(sent));
  }
  EXPECT_EQ(sent, 3);
}

TEST(PendingRequests, AResponseInTimeEndsTheRowOfTimeOuts) {
  Requests requests;
  for (int i = 0; i < 5; ++i) {
    add(requests, {"a"}, at(i));
    requests.expire(at(i));
    EXPECT_EQ(after_response(requests), "(a)");
    EXPECT_FALSE(requests.must_reconnect(0));
  }
}

TEST(PendingRequests, TheEndOfTheConnectionCountsWhatWaited) {
  Requests requests;
  add(requests, {"a", "b"}, at(10));
  requests.expire(at(10));
  add(requests, {"c"});
  add(requests, {"d"}, at(20));
  requests.expire(at(20));
  const auto ended = requests.clear();
  EXPECT_EQ(ended.waiting, 1u);
  EXPECT_EQ(ended.expired, 1u);  // add() has forgotten "a" and "b"
  EXPECT_EQ(requests.clear().waiting, 0u);
}

TEST(PendingRequests, ResponsesWithNumbersAreTakenInTheOrderOfTheRequests) {
  Requests requests;
  add(requests, {"a"});
  add(requests, {"b"}, at(10));
  add(requests, {"c"});
  EXPECT_EQ(after_response(requests, 2), "");
  EXPECT_EQ(after_response(requests, 0), "a");
  EXPECT_EQ(requests.expire(at(10)), 1u);
  EXPECT_EQ(taken(requests), "c");
  EXPECT_EQ(requests.take_skipped(), 1u);  // "b"
  EXPECT_EQ(requests.take_skipped(), 0u);
  EXPECT_EQ(after_response(requests, 1), "");
  EXPECT_FALSE(requests.must_reconnect(0));
}

TEST(PendingRequests, NeverReconnectsForLostResponsesOfAServerThatRepeatsNumbers) {
  Requests requests;
  add(requests, {"a"});
  EXPECT_EQ(after_response(requests, 0), "a");
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(requests.add("b", at(10)), i > 0 ? 1u : 0u);
    requests.expire(at(10));
    EXPECT_FALSE(requests.must_reconnect(0)) << i;
    EXPECT_TRUE(requests.has_room(1)) << i;
  }
}

TEST(PendingRequests, RefusesAResponseWithoutARequest) {
  Requests requests;
  EXPECT_EQ(after_response(requests),
            "error: an answer does not belong to a request: more answers than requests");
  add(requests, {"a"});
  EXPECT_EQ(after_response(requests), "a");
  EXPECT_EQ(requests.accept({}, 1).error().code, Code::PEER_MESSAGE_INVALID);
}

TEST(PendingRequests, RefusesANumberThatWasNotSentOnTheConnection) {
  Requests requests;
  add(requests, {"a"});
  EXPECT_EQ(after_response(requests, 7),
            "error: an answer does not belong to a request: weir.seq 7");
  requests.clear();
  EXPECT_EQ(requests.next_number(), 1u);
  add(requests, {"b"});
  EXPECT_EQ(after_response(requests, 0),
            "error: an answer does not belong to a request: weir.seq 0");
  EXPECT_EQ(requests.waiting(), 1u);
}

TEST(PendingRequests, RefusesAResponseWithoutANumberAfterNumberedOnes) {
  Requests requests;
  add(requests, {"a", "b"});
  EXPECT_EQ(after_response(requests, 0), "a");
  EXPECT_EQ(after_response(requests),
            "error: an answer has no weir.seq: an answer without a number");
}

TEST(PendingRequests, ANumberedResponseThatComesTwiceIsGivenToNoOtherRequest) {
  Requests requests;
  add(requests, {"a", "b"});
  EXPECT_EQ(after_response(requests, 0), "a");
  EXPECT_EQ(after_response(requests, 0), "");
  EXPECT_EQ(requests.waiting(), 1u);
}

}  // namespace pending_requests_test
}  // namespace weir::edge
