// invoke-async with an engine that does not answer: async-timeout.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "elements/tensor_filter/async_filter_test_support.hpp"

namespace async_timeout_test {

using namespace weir::test;
using namespace weir::test::async;

TEST(TensorFilterAsyncTimeout, FailsIfTheEngineDoesNotAnswerInTime) {
  auto h = harness("outputs:1,in-flight:3,never:1", "async-timeout=20");
  Errors errors(h);
  GstFlowReturn flow = GST_FLOW_OK;
  std::thread streaming([&] {  // until all places are used; then it blocks
    for (int i = 0; i < 5 && flow == GST_FLOW_OK; ++i) flow = push(h, 1);
  });
  const std::string error = await(errors);
  streaming.join();
  EXPECT_SAYS(error, "WEIR-3015: the engine did not answer in time");
  EXPECT_SAYS(error, "async-timeout=20 ms, frames in progress: ");
  EXPECT_SAYS(error, "fix: tensor_filter invoke-async=true async-timeout=200");
  EXPECT_EQ(flow, GST_FLOW_ERROR) << "the error is also returned upstream";
  EXPECT_EQ(push(h, 1), GST_FLOW_ERROR);
  EXPECT_EQ(errors.next(), "") << "posted once";
  End end(h);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  end.wait();
  EXPECT_EQ(stat(h, kFilter, "dropped-error"), stat(h, kFilter, "received"));
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 0u);
  expect_sums(h);
}

// Frames that a flush cancelled keep their places; only a frame that waits for one fails.
TEST(TensorFilterAsyncTimeout, FailsIfNoPlaceIsFreedAfterAFlush) {
  auto h = harness("outputs:1,in-flight:1,never:1", "async-timeout=20");
  Errors errors(h);
  ASSERT_EQ(push(h, 1), GST_FLOW_OK);
  flush(h);
  EXPECT_EQ(push(h, 2), GST_FLOW_ERROR) << "after the timeout";
  EXPECT_SAYS(await(errors), "async-timeout=20 ms, frames in progress: 1");
  EXPECT_EQ(stat(h, kFilter, "dropped"), 2u);
  EXPECT_GE(stat(h, kFilter, "dropped-error"), 1u);
  expect_sums(h);
}

TEST(TensorFilterAsyncTimeout, ContinuesAfterATimeoutAndAFlush) {
  auto h = harness("outputs:1,in-flight:4,until-cancelled:1", "async-timeout=20");
  Errors errors(h);
  ASSERT_EQ(push(h, 1), GST_FLOW_OK);
  EXPECT_SAYS(await(errors), "WEIR-3015");
  flush(h);
  EXPECT_EQ(push(h, 2), GST_FLOW_OK);
  EXPECT_SAYS(await(errors), "WEIR-3015") << "fails again, because the engine still hangs";
  EXPECT_EQ(stat(h, kFilter, "dropped-error"), 2u);
}

TEST(TensorFilterAsyncTimeout, WaitsForeverWithoutATimeout) {
  auto h = harness("outputs:1,in-flight:8,reverse:3", "async-timeout=0");
  Errors errors(h);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(push(h, static_cast<float>(i)), GST_FLOW_OK);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(pull(h), static_cast<float>(i));
  EXPECT_EQ(errors.next(), "");
}

}  // namespace async_timeout_test
