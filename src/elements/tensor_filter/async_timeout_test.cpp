// invoke-async with an engine that says nothing: async-timeout.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "elements/tensor_filter/async_filter.hpp"

namespace {

using namespace weir::test;
using namespace weir::test::async;

TEST(TensorFilterAsyncTimeout, FailsWhereTheEngineSaysNothingForTooLong) {
  auto h = harness("outputs:1,in-flight:3,never:1", "async-timeout=20");
  Errors errors(h);
  GstFlowReturn flow = GST_FLOW_OK;
  std::thread streaming([&] {  // until the places are taken, and then it waits
    for (int i = 0; i < 5 && flow == GST_FLOW_OK; ++i) flow = push(h, 1);
  });
  const std::string error = await(errors);
  streaming.join();
  EXPECT_SAYS(error, "WEIR-3015: the engine has said nothing of its frames in time");
  EXPECT_SAYS(error, "async-timeout=20 ms, frames in work: ");
  EXPECT_SAYS(error, "fix: tensor_filter invoke-async=true async-timeout=200");
  EXPECT_EQ(flow, GST_FLOW_ERROR) << "who brings frames hears of it";
  EXPECT_EQ(push(h, 1), GST_FLOW_ERROR);
  EXPECT_EQ(errors.next(), "") << "told once";
  End end(h);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  end.wait();
  EXPECT_EQ(stat(h, kFilter, "dropped-error"), stat(h, kFilter, "received"));
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 0u);
  expect_sums(h);
}

// What a flush gave up keeps its places: who waits for one is told, nobody else is.
TEST(TensorFilterAsyncTimeout, FailsWhereNoPlaceBecomesFreeAfterAFlush) {
  auto h = harness("outputs:1,in-flight:1,never:1", "async-timeout=20");
  Errors errors(h);
  ASSERT_EQ(push(h, 1), GST_FLOW_OK);
  flush(h);
  EXPECT_EQ(push(h, 2), GST_FLOW_ERROR) << "after the time-out";
  EXPECT_SAYS(await(errors), "async-timeout=20 ms, frames in work: 1");
  EXPECT_EQ(stat(h, kFilter, "dropped"), 2u);
  EXPECT_GE(stat(h, kFilter, "dropped-error"), 1u);
  expect_sums(h);
}

TEST(TensorFilterAsyncTimeout, GoesOnAfterATimeOutWhenItIsFlushed) {
  auto h = harness("outputs:1,in-flight:4,until-cancelled:1", "async-timeout=20");
  Errors errors(h);
  ASSERT_EQ(push(h, 1), GST_FLOW_OK);
  EXPECT_SAYS(await(errors), "WEIR-3015");
  flush(h);
  EXPECT_EQ(push(h, 2), GST_FLOW_OK);
  EXPECT_SAYS(await(errors), "WEIR-3015") << "and fails again, for the engine is as it was";
  EXPECT_EQ(stat(h, kFilter, "dropped-error"), 2u);
}

TEST(TensorFilterAsyncTimeout, WaitsAsLongAsItTakesWithoutATimeOut) {
  auto h = harness("outputs:1,in-flight:8,reverse:3", "async-timeout=0");
  Errors errors(h);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(push(h, static_cast<float>(i)), GST_FLOW_OK);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(pull(h), static_cast<float>(i));
  EXPECT_EQ(errors.next(), "");
}

}  // namespace
