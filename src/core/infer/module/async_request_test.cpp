// Tests requests of asynchronous engines: ends, abandoned requests, surplus and missing calls.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/async_request_test_support.hpp"

#include <deque>
#include <thread>

#include "becomes.hpp"
#include "says.hpp"
#include "weir/abi.h"

namespace weir::infer::async_test {
namespace async_request_test {

TEST_F(AsyncRequest, GivesAnyNumberOfOutputsAndOneEnd) {
  const auto session = open();
  for (const int count : {0, 1, 3}) {
    Received received;
    std::vector<int> expected;
    ASSERT_TRUE(*submit(*session, &received));
    std::deque<Output> outputs;
    for (int i = 0; i < count; ++i) {
      complete(submitted.back(), &outputs.emplace_back(i), true);
      expected.push_back(i);
      EXPECT_EQ(outputs.back().released, 1) << "not taken over";
    }
    EXPECT_TRUE(received.ends.empty());
    EXPECT_EQ(session->requests().in_flight(), 1u);
    complete(submitted.back(), nullptr, false);
    EXPECT_EQ(received.outputs, expected);
    EXPECT_EQ(received.ends, std::vector<std::string>{""});
    EXPECT_EQ(session->requests().in_flight(), 0u);
    EXPECT_TRUE(last_.expired());
  }
}

TEST_F(AsyncRequest, MayEndWithItsOnlyOutput) {
  const auto session = open();
  Received received;
  Output output(7);
  ASSERT_TRUE(*submit(*session, &received, true));
  complete(submitted[0], &output, false);
  EXPECT_EQ(received.outputs, std::vector<int>{7});
  EXPECT_EQ(received.ends.size(), 1u);
  EXPECT_EQ(output.released, 0) << "the receiver has it";
}

TEST_F(AsyncRequest, MayBeAnsweredBeforeSubmitReturns) {
  const auto session = open();
  Received received;
  Output output(7);
  on_submit = [&](weir_request* request, weir_error*) {
    complete(request, &output, false);
    return 0;
  };
  ASSERT_TRUE(*submit(*session, &received));
  EXPECT_EQ(received.outputs, std::vector<int>{7});
  EXPECT_EQ(received.ends.size(), 1u);
  EXPECT_TRUE(cancelled.empty());
}

TEST_F(AsyncRequest, SkipsFramesThatTheEngineDrops) {
  const auto session = open();
  Received received;
  Output output(7);
  ASSERT_TRUE(*submit(*session, &received));
  complete(submitted[0], &output, false, 1);
  EXPECT_TRUE(received.outputs.empty());
  EXPECT_EQ(received.ends, std::vector<std::string>{"1"});
  on_submit = [](weir_request*, weir_error*) { return 1; };
  ASSERT_TRUE(*submit(*session, &received));
  EXPECT_EQ(received.ends.size(), 2u) << "not even begun";
  EXPECT_EQ(session->requests().in_flight(), 0u);
}

TEST_F(AsyncRequest, PassesOnWhyAFrameHasNoResult) {
  const auto session = open();
  Received received;
  ASSERT_TRUE(*submit(*session, &received));
  complete(submitted[0], nullptr, true, WEIR_RESULT_LATE);  // no end yet
  EXPECT_TRUE(received.ends.empty());
  complete(submitted[0], nullptr, false, WEIR_RESULT_LOST);
  on_submit = [](weir_request*, weir_error*) { return int{WEIR_RESULT_REFUSED}; };
  ASSERT_TRUE(*submit(*session, &received));
  EXPECT_EQ(received.ends, (std::vector{std::to_string(int{WEIR_RESULT_LOST}),
                                        std::to_string(int{WEIR_RESULT_REFUSED})}));
}

TEST_F(AsyncRequest, IgnoresOutputsAfterTheEndAndFreesTheirMemory) {
  const auto session = open();
  Received received;
  Output late(1), unknown(2), none(3);
  ASSERT_TRUE(*submit(*session, &received));
  complete(submitted[0], nullptr, false);
  complete(submitted[0], &late, true);
  complete(submitted[0], nullptr, false, -WEIR_INVOKE_FAILED);
  complete(reinterpret_cast<weir_request*>(uintptr_t{0xdead0000}), &unknown, false);
  complete(nullptr, &none, false);
  EXPECT_TRUE(received.outputs.empty());
  EXPECT_EQ(received.ends.size(), 1u);
  EXPECT_EQ(late.released + unknown.released + none.released, 3);
  EXPECT_TRUE(host().cancelled(submitted[0])) << "its caller has left";
  EXPECT_TRUE(host().cancelled(nullptr));
  EXPECT_EQ(host().error_of(submitted[0]), nullptr);
  EXPECT_EQ(host().fail(host().error_of(submitted[0]), WEIR_INTERNAL, "late", "", "", "", ""),
            -WEIR_INTERNAL);
  ASSERT_TRUE(*submit(*session, &received));
  EXPECT_NE(submitted[1], submitted[0]) << "a number is never used again";
  EXPECT_FALSE(host().cancelled(submitted[1]));
  complete(submitted[1], nullptr, false);
}

TEST_F(AsyncRequest, FailsWithTheEnginesMessageAndIgnoresLaterOutputs) {
  const auto session = open();
  Received received;
  ASSERT_TRUE(*submit(*session, &received));
  host().fail(host().error_of(submitted[0]), WEIR_INVOKE_FAILED, "too hot", "90 degrees", "less",
              nullptr, nullptr);
  host().complete(submitted[0], -WEIR_INVOKE_FAILED, nullptr, 1);
  ASSERT_EQ(received.ends.size(), 1u);
  EXPECT_SAYS(received.ends[0], "WEIR-3006: too hot");
  EXPECT_EQ(session->requests().in_flight(), 1u) << "the engine still works on it";
  EXPECT_FALSE(last_.expired()) << "and reads its memory";
  Output output(1);
  complete(submitted[0], &output, true);
  complete(submitted[0], nullptr, false);
  EXPECT_TRUE(received.outputs.empty());
  EXPECT_EQ(received.ends.size(), 1u);
  EXPECT_EQ(session->requests().in_flight(), 0u);
  ASSERT_TRUE(*submit(*session, &received));
  complete(submitted[1], nullptr, false, -WEIR_OUT_OF_MEMORY);
  EXPECT_SAYS(received.ends[1], "WEIR-9001: the engine failed on a frame");
}

TEST_F(AsyncRequest, EndsWithAnErrorOfTheHostAndIsCancelledByTheNextFlush) {
  const auto session = open();
  auto& requests = session->requests();
  Received received;
  EXPECT_FALSE(requests.has_waiting_receivers());
  ASSERT_TRUE(*submit(*session, &received));
  ASSERT_TRUE(*submit(*session, &received));
  EXPECT_TRUE(requests.has_waiting_receivers());
  requests.fail({.code = Code::WORKER_TIMEOUT, .what = "too slow"});
  ASSERT_EQ(received.ends.size(), 2u);
  EXPECT_SAYS(received.ends[0], "WEIR-3015: too slow");
  EXPECT_EQ(received.ends[1], received.ends[0]);
  EXPECT_FALSE(requests.has_waiting_receivers());
  EXPECT_EQ(requests.in_flight(), 2u) << "the engine may still work on them";
  EXPECT_FALSE(last_.expired()) << "and read their memory";
  EXPECT_TRUE(cancelled.empty());
  EXPECT_FALSE(*submit(*session, &received)) << "nothing is taken";
  EXPECT_FALSE(requests.wait_for_room());
  Output late(1);
  complete(submitted[0], &late, false);
  EXPECT_TRUE(received.outputs.empty());
  EXPECT_EQ(late.released, 1);
  EXPECT_EQ(received.ends.size(), 2u);
  EXPECT_EQ(session->abandon(), 0u) << "all have received their end";
  EXPECT_EQ(cancelled, std::vector<weir_request*>{submitted[1]});
  requests.resume();
  ASSERT_TRUE(*submit(*session, &received));
  complete(submitted[2], nullptr, false);
  EXPECT_EQ(received.ends.back(), "");
}

TEST_F(AsyncRequest, IsPendingForACallerThatWaitsForAbandonedRequests) {
  max_in_flight = 1;
  const auto session = open();
  auto& requests = session->requests();
  Received received;
  ASSERT_TRUE(*submit(*session, &received));
  session->abandon();
  requests.resume();
  EXPECT_FALSE(requests.has_waiting_receivers()) << "abandoned requests have no receiver";
  bool room = true;
  std::thread waiter([&] { room = requests.wait_for_room(); });
  EXPECT_TRUE(becomes_true([&] { return requests.has_waiting_receivers(); },
                           "a thread that waits for space"));
  requests.fail({.code = Code::WORKER_TIMEOUT, .what = "too slow"});
  waiter.join();
  EXPECT_FALSE(room);
  EXPECT_TRUE(received.ends.empty());
}

TEST_F(AsyncRequest, ReportsThatTheEngineRejectsAFrame) {
  const auto session = open();
  Received received;
  on_submit = [](weir_request*, weir_error* error) {
    return host().fail(error, WEIR_SPEC_MISMATCH, "not today", nullptr, nullptr, nullptr, nullptr);
  };
  const auto refused = submit(*session, &received);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().what, "not today");
  EXPECT_TRUE(received.ends.empty()) << "the caller knows";
  EXPECT_EQ(session->requests().in_flight(), 0u);
  on_submit = [](weir_request* request, weir_error*) {
    complete(request, nullptr, false);
    return -WEIR_INTERNAL;
  };
  EXPECT_TRUE(*submit(*session, &received)) << "it had ended before it was refused";
  EXPECT_EQ(received.ends.size(), 1u);
}

TEST_F(AsyncRequest, AbandonsAndCancelsAndKeepsMemoryUntilTheEnd) {
  const auto session = open();
  Received received;
  ASSERT_TRUE(*submit(*session, &received));
  ASSERT_TRUE(*submit(*session, &received));
  const auto receiver = last_;
  complete(submitted[0], nullptr, false);
  EXPECT_EQ(session->abandon(), 1u);
  EXPECT_EQ(cancelled, std::vector<weir_request*>{submitted[1]});
  EXPECT_TRUE(host().cancelled(submitted[1]));
  EXPECT_EQ(session->abandon(), 0u) << "once";
  EXPECT_EQ(cancelled.size(), 1u);
  EXPECT_FALSE(*submit(*session, &received)) << "until resume()";
  session->requests().resume();
  EXPECT_FALSE(receiver.expired()) << "the engine may still read what it was given";
  Output late(1);
  complete(submitted[1], &late, true);
  EXPECT_EQ(session->requests().in_flight(), 1u);
  complete(submitted[1], nullptr, false, -WEIR_CANCELLED);
  EXPECT_EQ(session->requests().in_flight(), 0u);
  EXPECT_TRUE(receiver.expired());
  EXPECT_TRUE(received.outputs.empty());
  EXPECT_EQ(received.ends.size(), 1u) << "that of the first";
  EXPECT_EQ(late.released, 1);
}

TEST_F(AsyncRequest, CancelsARequestThatIsAbandonedDuringSubmit) {
  const auto session = open();
  Received received;
  size_t count = 0;
  on_submit = [&](weir_request*, weir_error*) {
    count = session->abandon();
    EXPECT_TRUE(cancelled.empty()) << "the engine does not know of it yet";
    return 0;
  };
  ASSERT_TRUE(*submit(*session, &received));
  EXPECT_EQ(count, 1u);
  EXPECT_EQ(cancelled, submitted);
  on_submit = [&](weir_request*, weir_error*) {
    count = session->abandon();
    return -WEIR_INTERNAL;
  };
  session->requests().resume();
  EXPECT_TRUE(*submit(*session, &received)) << "it is among the abandoned";
  EXPECT_EQ(count, 1u);
  EXPECT_TRUE(received.ends.empty());
}

TEST_F(AsyncRequest, WaitsForRoom) {
  const auto session = open();
  Received received;
  ASSERT_TRUE(*submit(*session, &received));
  ASSERT_TRUE(session->requests().wait_for_room());
  ASSERT_TRUE(*submit(*session, &received));
  std::thread other([&] { EXPECT_TRUE(session->requests().wait_for_room()); });
  complete(submitted[1], nullptr, false);
  other.join();
  ASSERT_TRUE(*submit(*session, &received));
  std::thread interrupted([&] { EXPECT_FALSE(session->requests().wait_for_room()); });
  EXPECT_EQ(session->abandon(), 2u);
  interrupted.join();
  session->requests().resume();
  std::thread after([&] { EXPECT_TRUE(session->requests().wait_for_room()); });
  EXPECT_EQ(session->requests().in_flight(), 2u) << "what is abandoned keeps its place";
  complete(submitted[0], nullptr, false);
  after.join();
  complete(submitted[2], nullptr, false);
}

TEST_F(AsyncRequest, WaitsUntilNoneIsInFlight) {
  const auto session = open();
  Received received;
  EXPECT_TRUE(session->requests().wait_until_idle());
  ASSERT_TRUE(*submit(*session, &received));
  std::thread other([&] { EXPECT_TRUE(session->requests().wait_until_idle()); });
  complete(submitted[0], nullptr, false);
  other.join();
}

TEST_F(AsyncRequest, AbandonsOpenRequestsWhenTheSessionIsFreed) {
  Received received;
  auto session = open();
  ASSERT_TRUE(*submit(*session, &received));
  const auto never = last_;
  session.reset();
  EXPECT_TRUE(freed);
  EXPECT_EQ(cancelled, submitted);
  EXPECT_TRUE(never.expired()) << "no leak";
  Output late(1);
  complete(submitted[0], &late, true);
  complete(submitted[0], nullptr, false);
  EXPECT_EQ(late.released, 1);
  EXPECT_TRUE(received.outputs.empty() && received.ends.empty());
}

TEST_F(AsyncRequest, HandlesInconsistentOutputs) {
  const auto session = open();
  struct Deaf final : RequestReceiver {
    void output(weir_frame&) noexcept override {}
    void end(const Result<int>&) noexcept override {}
  };
  ASSERT_TRUE(*session->submit(in_, std::make_shared<Deaf>()));
  weir_frame frame{};
  const auto say = [&] { host().complete(submitted[0], 0, &frame, 1); };
  say();
  frame.struct_size = sizeof frame;
  frame.n_tensors = UINT32_MAX;
  say();
  std::vector<weir_tensor> many(WEIR_TENSOR_LIMIT);
  frame.tensors = many.data();
  say();
  complete(submitted[0], nullptr, false, INT32_MIN);
  EXPECT_EQ(session->requests().in_flight(), 0u);
}

TEST_F(AsyncRequest, EndsWithAnErrorForAFrameThatEndsBeforeItsTensors) {
  for (const uint32_t size : {0u, 8u, uint32_t{offsetof(weir_frame, pts)} - 1}) {
    submitted.clear();
    const auto session = open();
    Received received;
    ASSERT_TRUE(*submit(*session, &received));
    weir_frame frame{};
    frame.struct_size = size;
    frame.n_tensors = 1;
    frame.tensors = reinterpret_cast<weir_tensor*>(1);  // past the end, must not be read
    host().complete(submitted[0], 0, &frame, 1);
    EXPECT_TRUE(received.outputs.empty());
    ASSERT_EQ(received.ends.size(), 1u);
    EXPECT_SAYS(received.ends[0], "the engine completed a request with an incomplete weir_frame");
    EXPECT_SAYS(received.ends[0], "offered: struct_size " + std::to_string(size));
    EXPECT_SAYS(received.ends[0], "fix: frame.struct_size = sizeof frame;");
    complete(submitted[0], nullptr, false);
    EXPECT_EQ(session->requests().in_flight(), 0u);
    EXPECT_EQ(received.ends.size(), 1u);
  }
}

TEST_F(AsyncRequest, KnowsWhichEnginesAnswerAsynchronously) {
  EXPECT_TRUE(open()->is_asynchronous());
  engine_.cancel = nullptr;
  EXPECT_TRUE(open()->is_asynchronous());
  flags = 0;
  EXPECT_FALSE(open()->is_asynchronous()) << "not this model";
  flags = WEIR_MODEL_ASYNC;
  engine_.struct_size = offsetof(weir_engine, submit);
  EXPECT_FALSE(open()->is_asynchronous()) << "a shorter table";
  engine_.struct_size = sizeof engine_;
  engine_.submit = nullptr;
  EXPECT_FALSE(open()->is_asynchronous());
}

TEST_F(AsyncRequest, AllowsOneRequestByDefault) {
  max_in_flight = 0;
  const auto session = open();
  Received received;
  ASSERT_TRUE(session->requests().wait_for_room());
  ASSERT_TRUE(*submit(*session, &received));
  std::thread other([&] { EXPECT_TRUE(session->requests().wait_for_room()); });
  complete(submitted[0], nullptr, false);
  other.join();
}

}  // namespace async_request_test
}  // namespace weir::infer::async_test
