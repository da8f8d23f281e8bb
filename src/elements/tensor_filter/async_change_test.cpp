// Tests of invoke-async written while frames flow. The engine is tests/support/async_engine.cpp:
// invoke() returns a frame as it is, submit() returns x, x + 1, ... for a frame x.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <thread>

#include "elements/tensor_filter/async_filter_test_support.hpp"

namespace async_change_test {

using namespace weir::test;
using namespace weir::test::async;

using Floats = std::vector<float>;

class AsyncChange : public ::testing::Test {
 protected:
  void start(const std::string& custom, const std::string& properties = "") {
    h_ = harness(custom, properties);
    observe();
  }
  void start_synchronous(const std::string& properties) {
    h_ = harness("", "invoke-async=false " + properties);
    observe();
  }
  void observe() {
    filter_ = find_element(h_, kFilter);
    messages_ = std::make_unique<Errors>(h_);
  }
  void TearDown() override {
    messages_.reset();
    filter_ = {};
    h_.reset();
  }
  void set(bool asynchronous) {
    g_object_set(filter_.get(), "invoke-async", asynchronous, nullptr);
  }
  bool is_async() const {
    gboolean value = FALSE;
    g_object_get(filter_.get(), "invoke-async", &value, nullptr);
    return value != FALSE;
  }
  Floats pull(size_t count) {
    Floats out;
    while (out.size() < count) out.push_back(async::pull(h_));
    return out;
  }

  Harness h_;
  Ref<GstElement> filter_;
  std::unique_ptr<Errors> messages_;
};

TEST_F(AsyncChange, AppliesToTheNextFrame) {
  start("outputs:2");
  push(h_, 1);
  EXPECT_EQ(pull(2), (Floats{1, 2}));
  set(false);
  push(h_, 5);
  push(h_, 6);
  EXPECT_EQ(pull(2), (Floats{5, 6})) << "one output for each frame";
  set(true);
  push(h_, 8);
  EXPECT_EQ(pull(2), (Floats{8, 9}));
  EXPECT_TRUE(is_async());
  EXPECT_EQ(messages_->next(), "");
  EXPECT_EQ(messages_->next_warning(), "");
  EXPECT_EQ(stat(h_, kFilter, "pushed"), 6u);
  expect_sums(h_);
}

TEST_F(AsyncChange, FramesInProgressLeaveFirst) {
  start("outputs:2,in-flight:4");
  for (const float x : {10.f, 20.f, 30.f}) push(h_, x);
  set(false);
  push(h_, 40);
  EXPECT_EQ(pull(7), (Floats{10, 11, 20, 21, 30, 31, 40}));
  gst_harness_push_event(h_.get(), gst_event_new_eos());
  expect_sums(h_);
}

TEST_F(AsyncChange, AppliesToAStreamThatHasNoFrameYet) {
  start("outputs:3");
  set(false);
  push(h_, 1);
  set(true);
  push(h_, 2);
  EXPECT_EQ(pull(4), (Floats{1, 2, 3, 4}));
}

TEST_F(AsyncChange, OtherCapsArriveAfterIt) {
  start("outputs:1");
  push(h_, 1);
  set(false);
  gst_harness_set_src_caps_str(h_.get(), tensors("float32", "4:1").c_str());
  push(h_, 2);
  EXPECT_EQ(pull(2), (Floats{1, 2}));
}

TEST_F(AsyncChange, StartsAgainWithTheNewValue) {
  start("outputs:2");
  push(h_, 1);
  set(false);
  push(h_, 3);
  EXPECT_EQ(pull(3), (Floats{1, 2, 3}));
  gst_element_set_state(filter_.get(), GST_STATE_READY);
  gst_element_set_state(filter_.get(), GST_STATE_PLAYING);
  gst_harness_push_event(h_.get(), gst_event_new_stream_start("again"));
  gst_harness_set_src_caps_str(h_.get(), kFour.c_str());
  gst_harness_push_event(h_.get(), time_segment());
  push(h_, 7);
  EXPECT_EQ(pull(1), Floats{7});
  set(true);
  push(h_, 8);
  EXPECT_EQ(pull(2), (Floats{8, 9}));
}

// ---- Values that cannot act ------------------------------------------------------------------

TEST_F(AsyncChange, IsRejectedForASynchronousModel) {
  start_synchronous("custom=synchronous:1");
  set(true);
  ASSERT_EQ(push(h_, 5), GST_FLOW_OK);
  EXPECT_EQ(pull(1), Floats{5});
  const std::string text = messages_->next_warning();
  EXPECT_SAYS(text, "WEIR-3005: the engine supports only synchronous invokes of this model");
  EXPECT_SAYS(text, "fix: tensor_filter invoke-async=false");
  EXPECT_FALSE(is_async());
  EXPECT_EQ(messages_->next(), "") << "no error";
}

TEST_F(AsyncChange, IsRejectedWithInputsAmongTheOutputs) {
  start_synchronous("output-combination=i0,o0");
  set(true);
  ASSERT_EQ(push(h_, 5), GST_FLOW_OK);
  EXPECT_EQ(pull(1), Floats{5});
  EXPECT_SAYS(messages_->next_warning(), "output-combination cannot contain inputs");
  EXPECT_FALSE(is_async());
  // The second write makes the first one valid.
  g_object_set(filter_.get(), "output-combination", "o0", nullptr);
  ASSERT_EQ(push(h_, 6), GST_FLOW_OK);
  EXPECT_TRUE(is_async());
  EXPECT_EQ(messages_->next_warning(), "");
}

// ---- Flushes and stops at the same time -------------------------------------------------------

TEST_F(AsyncChange, CountsEveryFrameUnderFlushes) {
  start("outputs:2,in-flight:4");
  gst_harness_set_drop_buffers(h_.get(), TRUE);
  for (int round = 0; round < 20; ++round) {
    std::thread flusher([&] { gst_harness_push_event(h_.get(), gst_event_new_flush_start()); });
    for (int i = 0; i < 8; ++i) {
      set(i % 2 == 0);
      push(h_, 1);
    }
    flusher.join();
    gst_harness_push_event(h_.get(), gst_event_new_flush_stop(TRUE));
    gst_harness_push_event(h_.get(), time_segment());
    EXPECT_EQ(stat(filter_.get(), "held"), 0u);
  }
  expect_sums(h_);
  EXPECT_EQ(messages_->next(), "");
}

TEST_F(AsyncChange, AStopEndsIt) {
  for (unsigned round = 0; round < 10; ++round) {
    start("outputs:2,in-flight:4");
    gst_harness_set_drop_buffers(h_.get(), TRUE);
    std::atomic<bool> flows{true};
    std::thread streaming([&] {
      for (int i = 0; flows; ++i) {
        set(i % 2 == 0);
        if (push(h_, 1) != GST_FLOW_OK) return;
      }
    });
    const auto enough = [&] { return stat(filter_.get(), "received") >= 1 + round; };
    EXPECT_TRUE(becomes_true(enough, "frames"));
    gst_element_set_state(filter_.get(), GST_STATE_NULL);
    flows = false;
    streaming.join();
    EXPECT_EQ(stat(filter_.get(), "held"), 0u);
    EXPECT_EQ(messages_->next(), "");
    TearDown();
  }
}

}  // namespace async_change_test
