// invoke-async at its limits: max-bytes of frames in progress and of waiting outputs, and
// when-busy. The engine is tests/support/async_engine.cpp; every frame and every output has 16
// bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "elements/tensor_filter/async_filter_test_support.hpp"
#include "elements/tests/closed_pad_test_support.hpp"

namespace async_bytes_test {

using namespace weir::test;
using namespace weir::test::async;

using Numbers = std::vector<float>;

Numbers all(const Harness& h) {
  End end(h);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  end.wait();
  Numbers out;
  while (gst_harness_buffers_in_queue(h.get()) > 0) out.push_back(pull(h));
  return out;
}
// The sink holds one output; then a frame produces nine more: 9 to 17. Three of them fit within the
// limit in addition to their frame and the held output.
void push_nine_after_one(const Harness& h, ClosedPad& outside) {
  push(h, 1);
  outside.wait_until_one_is_held();
  wait_for_stat(h, kFilter, "bytes-held", 16);
  push(h, 9);
}

TEST(TensorFilterAsyncBytes, BlocksTheEngineAtTheLimit) {
  auto h = harness("in-flight:2", "max-bytes=80");
  ClosedPad outside(h->sinkpad);
  push_nine_after_one(h, outside);
  wait_for_stat(h, kFilter, "bytes-held", 80);
  outside.open();
  EXPECT_EQ(all(h), (Numbers{1, 9, 10, 11, 12, 13, 14, 15, 16, 17}));
  EXPECT_EQ(stat(h, kFilter, "bytes-most"), 80u);
  wait_for_stat(h, kFilter, "bytes-held", 0);  // a frame is released after its push
  EXPECT_EQ(stat(h, kFilter, "outputs-dropped"), 0u);
  expect_sums(h);
}

// Six of the nine outputs are dropped; `left` are pushed.
void expect_six_dropped(const std::string& when_busy, const Numbers& left) {
  auto h = harness("in-flight:2", "max-bytes=80 when-busy=" + when_busy);
  ClosedPad outside(h->sinkpad);
  push_nine_after_one(h, outside);
  wait_for_stat(h, kFilter, "invokes", 2);
  outside.open();
  EXPECT_EQ(all(h), left);
  EXPECT_EQ(stat(h, kFilter, "bytes-most"), 80u);
  EXPECT_EQ(stat(h, kFilter, "outputs-dropped"), 6u);
  EXPECT_EQ(stat(h, kFilter, "consumed"), 2u);
  expect_sums(h);
}

TEST(TensorFilterAsyncBytes, DropsNewOutputs) {
  expect_six_dropped("drop-new", {1, 9, 10, 11});
}

TEST(TensorFilterAsyncBytes, DropsOldOutputs) {
  expect_six_dropped("drop-old", {1, 15, 16, 17});
}

// Each output exceeds the limit.
TEST(TensorFilterAsyncBytes, NeverBlocksAStreamForever) {
  for (const char* custom : {"in-flight:1", "in-flight:3", "in-flight:1,inline:1"}) {
    auto h = harness(custom, "max-bytes=1");
    Numbers expected;
    for (int i = 0; i < 20; ++i) {
      for (int k = 0; k < i % 4; ++k) expected.push_back(static_cast<float>(i % 4 + k));
      ASSERT_EQ(push(h, static_cast<float>(i % 4)), GST_FLOW_OK);
    }
    EXPECT_EQ(all(h), expected) << custom;
    expect_sums(h);
  }
}

// The engine answers the newest of three frames first: its outputs wait for the next ones.
TEST(TensorFilterAsyncBytes, FailsIfOnlyTheEngineCouldFreeSpace) {
  auto h = harness("outputs:3,in-flight:3,reverse:3", "max-bytes=64");
  Errors errors(h);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(push(h, static_cast<float>(i)), GST_FLOW_OK);
  const std::string error = await(errors);
  EXPECT_SAYS(error, "WEIR-2006: outputs that wait for those of an older frame exceed max-bytes");
  EXPECT_SAYS(error, "offered: 64 bytes held and an output of 16 in addition, max-bytes=64");
  EXPECT_SAYS(
      error,
      "needed: max-bytes of 80 or more, or 0 for no limit; or when-busy=drop-new or drop-old");
  EXPECT_SAYS(error, "fix: tensor_filter invoke-async=true max-bytes=80");
  all(h);
  EXPECT_EQ(stat(h, kFilter, "bytes-most"), 64u);
  expect_sums(h);
}

TEST(TensorFilterAsyncBytes, DropsIfOnlyTheEngineCouldFreeSpace) {
  for (const char* when_busy : {"drop-new", "drop-old"}) {
    auto h = harness("outputs:3,in-flight:3,reverse:3",
                     "max-bytes=64 when-busy=" + std::string(when_busy));
    for (int i = 0; i < 3; ++i) ASSERT_EQ(push(h, static_cast<float>(10 * i)), GST_FLOW_OK);
    const auto out = all(h);
    EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
    EXPECT_EQ(stat(h, kFilter, "pushed") + stat(h, kFilter, "outputs-dropped"), 9u);
    EXPECT_GE(stat(h, kFilter, "outputs-dropped"), 2u);
    EXPECT_EQ(stat(h, kFilter, "consumed"), 3u);
    expect_sums(h);
  }
}

TEST(TensorFilterAsyncBytes, LimitsFramesInProgress) {
  auto h = harness("outputs:1,in-flight:8,never:1", "max-bytes=32");
  push(h, 1);
  push(h, 2);
  GstFlowReturn flow = GST_FLOW_OK;
  std::thread streaming([&] { flow = push(h, 3); });
  wait_for_stat(h, kFilter, "received", 3);
  EXPECT_EQ(stat(h, kFilter, "bytes-held"), 32u);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  streaming.join();
  EXPECT_EQ(flow, GST_FLOW_FLUSHING);
  EXPECT_EQ(stat(h, kFilter, "bytes-most"), 32u);
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 3u);
  expect_sums(h);
}

TEST(TensorFilterAsyncBytes, ReleasesAWaitingOutputOnFlush) {
  auto h = harness("in-flight:2", "max-bytes=80");
  ClosedPad outside(h->sinkpad);
  push_nine_after_one(h, outside);
  wait_for_stat(h, kFilter, "bytes-held", 80);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  outside.open();
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  EXPECT_EQ(stat(h, kFilter, "held"), 0u);
  wait_for_stat(h, kFilter, "bytes-held", 0);
  expect_sums(h);
}

TEST(TensorFilterAsyncBytes, StopsWhileAnOutputWaits) {
  auto h = harness("in-flight:2", "max-bytes=80");
  ClosedPad outside(h->sinkpad);
  push_nine_after_one(h, outside);
  wait_for_stat(h, kFilter, "bytes-held", 80);
  const auto element = find_element(h, kFilter);
  std::thread stop([&] { gst_element_set_state(element.get(), GST_STATE_NULL); });
  wait_for_stat(h, kFilter, "held", 0);
  outside.open();
  stop.join();
  EXPECT_EQ(stat(element.get(), "held"), 0u);
}

// An engine that downstream blocks does not time out. The other filter has the same timeout and
// starts to wait later.
TEST(TensorFilterAsyncBytes, ReportsNoTimeoutForABlockedEngine) {
  auto h = harness("in-flight:2", "max-bytes=80 async-timeout=40");
  Errors errors(h);
  ClosedPad outside(h->sinkpad);
  push_nine_after_one(h, outside);
  wait_for_stat(h, kFilter, "bytes-held", 80);
  auto other = harness("never:1", "async-timeout=40");
  Errors others(other);
  push(other, 1);
  EXPECT_SAYS(await(others), "WEIR-3015");
  EXPECT_EQ(errors.next(), "");
  outside.open();
  EXPECT_EQ(all(h).size(), 10u);
}

TEST(TensorFilterAsyncBytes, FailsIfTheLimitIsNeverFreed) {
  auto h = harness("outputs:1,in-flight:8,never:1", "max-bytes=16 async-timeout=20");
  Errors errors(h);
  push(h, 1);
  EXPECT_EQ(push(h, 2), GST_FLOW_ERROR) << "after the timeout";
  EXPECT_SAYS(await(errors),
              "async-timeout=20 ms, frames in progress: 1, and one waits for max-bytes");
  expect_sums(h);
}

// ---- When every place is used -----------------------------------------------------------------

TEST(TensorFilterAsyncBusy, WarnsThatWorkersHasNoEffect) {
  const auto element = lone_element(filter("outputs:1", "workers=3"));
  Errors messages(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  const auto text = messages.next_warning();
  gst_element_set_state(element.get(), GST_STATE_NULL);
  EXPECT_SAYS(text, "WEIR-1004: workers has no effect, because the engine uses its own threads");
  EXPECT_SAYS(text, "offered: workers=3 with invoke-async=true");
  EXPECT_SAYS(text, "fix: tensor_filter invoke-async=true workers=1");
}

TEST(TensorFilterAsyncBusy, DropsAFrameIfTheEngineIsFull) {
  for (const char* when_busy : {"drop-new", "drop-old"})
    for (const char* more : {"in-flight:1", "in-flight:8"}) {
      auto h = harness(std::string("outputs:1,never:1,") + more,
                       "max-bytes=16 when-busy=" + std::string(when_busy));
      for (int i = 0; i < 4; ++i) EXPECT_EQ(push(h, 1), GST_FLOW_OK) << "the source continues";
      EXPECT_EQ(stat(h, kFilter, "dropped-policy"), 3u) << more;
      EXPECT_EQ(stat(h, kFilter, "held"), 1u);
      flush(h);
      expect_sums(h);
    }
}

}  // namespace async_bytes_test
