// Frames that arrive while the model is busy, and flushes, failures and state changes while frames
// are in progress.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>

#include "becomes.hpp"
#include "elements/tensor_filter/gated_filter_test_support.hpp"
#include "elements/tests/closed_pad_test_support.hpp"

namespace weir::test {
namespace busy_test {

using Numbers = std::vector<float>;

void end_flush(const GatedFilter& f) {
  gst_harness_push_event(f.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(f.get(), gst_event_new_segment(&segment));
}
void flush(const GatedFilter& f) {
  gst_harness_push_event(f.get(), gst_event_new_flush_start());
  end_flush(f);
}

TEST(FilterWhenBusy, DropsTheNewFrame) {
  GatedFilter f("when-busy=drop-new");
  f.push(0);
  gate().wait_for_entered(1);
  for (const float n : {1, 2, 3}) EXPECT_EQ(f.push(n), GST_FLOW_OK) << "the source continues";
  EXPECT_EQ(f.stat("dropped-policy"), 3u);
  gate().let_go(0);
  f.wait_for_stat("workers-busy", 0);
  f.push(4);
  gate().let_go(4);
  EXPECT_EQ(f.pull(2), (Numbers{1, 5}));
  f.expect_all_accounted();
}

TEST(FilterWhenBusy, KeepsTheNewestFrame) {
  GatedFilter f("when-busy=drop-old");
  f.push(0);
  gate().wait_for_entered(1);
  for (const float n : {1, 2, 3}) EXPECT_EQ(f.push(n), GST_FLOW_OK) << "the source continues";
  EXPECT_EQ(f.stat("dropped-policy"), 2u);
  EXPECT_EQ(f.stat("waiting"), 1u);
  gate().open();
  EXPECT_EQ(f.pull(2), (Numbers{1, 4}));
  f.expect_all_accounted();
}

TEST(FilterWhenBusy, TheNewestFramesOfABatchReplaceWaitingOnes) {
  for (const bool old : {true, false}) {
    GatedFilter f(std::string("batch-size=2 batch-timeout=3600000000000 when-busy=drop-") +
                  (old ? "old" : "new"));
    for (int i = 1; i <= 4; ++i) {
      EXPECT_EQ(f.push(static_cast<float>(i)), GST_FLOW_OK);
      if (i == 2) gate().wait_for_entered(1);
    }
    for (int i = 5; i <= 7; ++i) EXPECT_EQ(f.push(static_cast<float>(i)), GST_FLOW_OK);
    EXPECT_EQ(f.stat("dropped-policy"), 3u);
    gate().open();
    const auto expected = old ? std::vector<float>{2, 3, 7, 8} : std::vector<float>{2, 3, 4, 5};
    EXPECT_EQ(f.pull(4), expected);
    f.expect_all_accounted();
  }
}

TEST(FilterWhenBusy, BlocksTheStreamingThread) {
  GatedFilter f("when-busy=block");
  f.push(0);
  f.push(1);
  std::atomic<bool> taken{false};
  std::thread other([&] {
    f.push(2);
    taken = true;
  });
  gate().wait_for_entered(1);
  f.wait_for_stat("received", 3);
  EXPECT_FALSE(taken);
  gate().let_go(0);
  other.join();
  gate().open();
  EXPECT_EQ(f.pull(3), (Numbers{1, 2, 3}));
  f.expect_all_accounted();
}

TEST(FilterWhenBusy, KeepsOrderAndCountsUnderLoad) {
  for (const char* when_busy : {"block", "drop-new", "drop-old"}) {
    GatedFilter f("workers=4 when-busy=" + std::string(when_busy), true);
    for (int i = 0; i < 1000; ++i) EXPECT_EQ(f.push(static_cast<float>(i)), GST_FLOW_OK);
    f.expect_all_accounted();
    const auto out = f.pull(f.stat("pushed"));
    EXPECT_TRUE(std::is_sorted(out.begin(), out.end())) << when_busy;
    EXPECT_TRUE(out.size() == 1000 || when_busy != std::string("block"));
  }
}

TEST(FilterMaxBytes, HoldsNoMoreThanTheLimit) {
  GatedFilter f("workers=2 max-bytes=31");
  f.push(0);
  std::thread other([&] { f.push(1); });
  f.wait_for_stat("received", 2);
  gate().wait_for_entered(1);
  gate().open();
  other.join();
  EXPECT_EQ(f.pull(2), (Numbers{1, 2}));
  EXPECT_EQ(f.stat("bytes-most"), 16u);
  EXPECT_EQ(gate().seen().max_at_once, 1);
}

TEST(FilterMaxBytes, DropsUnlessItBlocks) {
  for (const char* when_busy : {"drop-new", "drop-old"}) {
    GatedFilter f("workers=2 max-bytes=16 when-busy=" + std::string(when_busy));
    f.push(0);
    gate().wait_for_entered(1);
    f.push(1);
    EXPECT_EQ(f.stat("dropped-policy"), 1u);
    gate().open();
    EXPECT_EQ(f.pull(1), Numbers{1});
    f.expect_all_accounted();
  }
}

TEST(FilterMaxBytes, AcceptsASingleFrameAboveTheLimit) {
  GatedFilter f("workers=2 max-bytes=1", true);
  for (const float n : {0, 1, 2}) EXPECT_EQ(f.push(n), GST_FLOW_OK);
  EXPECT_EQ(f.pull(3), (Numbers{1, 2, 3}));
}

TEST(FilterWorkersFlush, DropsTheFramesInProgress) {
  GatedFilter f("workers=2");
  for (const float n : {0, 1, 2}) f.push(n);
  gate().wait_for_entered(2);
  gst_harness_push_event(f.get(), gst_event_new_flush_start());
  EXPECT_EQ(f.push(3), GST_FLOW_FLUSHING);
  end_flush(f);
  EXPECT_EQ(f.push(4), GST_FLOW_OK);
  gate().open();
  EXPECT_EQ(f.pull(1), Numbers{5});
  f.expect_all_accounted();
  EXPECT_EQ(f.stat("dropped-flush"), 3u) << "the pad itself rejected the fourth";
  EXPECT_EQ(f.waiting_outside(), 0u);
}

TEST(FilterWorkersFlush, WakesTheWaitingThread) {
  GatedFilter f("when-busy=block");
  f.push(0);
  f.push(1);
  GstFlowReturn flow = GST_FLOW_OK;
  std::thread other([&] { flow = f.push(2); });
  f.wait_for_stat("received", 3);
  gst_harness_push_event(f.get(), gst_event_new_flush_start());
  other.join();
  EXPECT_EQ(flow, GST_FLOW_FLUSHING);
  gate().open();
  f.expect_all_accounted();
  EXPECT_EQ(f.stat("dropped-flush"), 3u);
}

TEST(FilterWorkersFlush, EndsOnlyWhenNoOldFrameIsBeingPushed) {
  GatedFilter f("when-busy=block", true);
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(f.element(), "src"));
  ClosedPad standing(source.get());
  f.push(0);
  standing.wait_until_one_is_held();
  std::atomic<bool> let_go{false}, was_let_go{false}, started{false};
  std::thread other([&] {
    gst_harness_push_event(f.get(), gst_event_new_flush_start());
    started = true;
    gst_harness_push_event(f.get(), gst_event_new_flush_stop(TRUE));
    was_let_go = let_go.load();
  });
  EXPECT_TRUE(becomes_true([&] { return started.load(); }, "the beginning of the flush"));
  for (int i = 0; i < 100; ++i) std::this_thread::yield();
  let_go = true;
  standing.open();
  other.join();
  EXPECT_TRUE(was_let_go);
}

TEST(FilterWorkersFailure, IsPostedOnceAndRejectsLaterFrames) {
  GatedFilter f("workers=3 custom=fail:1");
  Errors errors(f.element());
  for (const float n : {0, 1, 1, 2}) EXPECT_EQ(f.push(n), GST_FLOW_OK);
  gate().wait_for_entered(3);
  gate().let_go(1);
  f.wait_for_stat("dropped-error", 2);
  while (f.push(9) == GST_FLOW_OK) gate().let_go(9);
  EXPECT_EQ(f.push(3), GST_FLOW_ERROR);
  gate().open();
  f.expect_all_accounted();
  EXPECT_EQ(f.pull(2), (Numbers{1, 3})) << "the other frames in progress are kept";
  EXPECT_SAYS(errors.next(), "ordered to fail");
  EXPECT_EQ(errors.next(), "");
}

TEST(FilterWorkersFailure, IsClearedByAFlush) {
  GatedFilter f("when-busy=block custom=fail:1", true);
  f.push(1);
  f.wait_for_stat("dropped-error", 1);
  flush(f);
  EXPECT_EQ(f.push(2), GST_FLOW_OK);
  EXPECT_EQ(f.pull(1), Numbers{3});
}

TEST(FilterWorkersFailure, CountsFramesThatTheEngineDrops) {
  GatedFilter f("workers=2 custom=drop:1", true);
  for (const float n : {0, 1, 2}) EXPECT_EQ(f.push(n), GST_FLOW_OK);
  EXPECT_EQ(f.pull(2), (Numbers{1, 3}));
  f.expect_all_accounted();
  EXPECT_EQ(f.stat("dropped-policy"), 1u);
}

// What the downstream element returns for each frame.
void return_flow(GstPad* pad, GstFlowReturn flow) {
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer data) {
        gst_buffer_unref(GST_PAD_PROBE_INFO_BUFFER(info));
        info->data = nullptr;
        GST_PAD_PROBE_INFO_FLOW_RETURN(info) = static_cast<GstFlowReturn>(GPOINTER_TO_INT(data));
        return GST_PAD_PROBE_HANDLED;
      },
      GINT_TO_POINTER(flow), nullptr);
}

TEST(FilterWorkersFlow, IsReturnedUpstream) {
  GatedFilter f("workers=2", true);
  return_flow(f.get()->sinkpad, GST_FLOW_EOS);
  EXPECT_TRUE(
      becomes_true([&] { return f.push(0) != GST_FLOW_OK; }, "the flow error of downstream"));
  EXPECT_EQ(f.push(1), GST_FLOW_EOS);
  f.expect_all_accounted();
  EXPECT_GE(f.stat("dropped-eos"), 1u);
}

TEST(FilterWorkersFlow, ContinuesWhileNothingIsLinked) {
  GatedFilter f("workers=2", true);
  return_flow(f.get()->sinkpad, GST_FLOW_NOT_LINKED);
  EXPECT_TRUE(
      becomes_true([&] { return f.push(0) != GST_FLOW_OK; }, "the flow error of downstream"));
  const uint64_t invokes = f.stat("invokes");
  EXPECT_EQ(f.push(1), GST_FLOW_NOT_LINKED);
  EXPECT_TRUE(becomes_true([&] { return f.stat("invokes") != invokes; }, "another invoke"));
  EXPECT_EQ(f.stat("dropped"), 0u);
}

TEST(FilterWorkersFlow, IsPostedAtEosIfItWasNotReturned) {
  GatedFilter f("workers=2");
  return_flow(f.get()->sinkpad, GST_FLOW_NOT_NEGOTIATED);
  Errors errors(f.element());
  f.push(0);
  gst_harness_push_event(f.get(), gst_event_new_eos());
  gate().wait_for_entered(1);
  gate().open();
  f.wait_for_stat("workers-busy", 0);
  EXPECT_SAYS(errors.next(), "Internal data stream error");
  EXPECT_EQ(errors.next(), "");
}

TEST(FilterWorkersState, StopsWhileFramesAreInProgress) {
  GatedFilter f("workers=2");
  for (const float n : {0, 1, 2, 3}) f.push(n);
  gate().wait_for_entered(2);
  std::thread opener([&] {
    f.wait_for_stat("waiting", 0);  // waiting frames were returned
    gate().open();
  });
  gst_element_set_state(f.element(), GST_STATE_NULL);
  opener.join();
  EXPECT_EQ(gate().seen().models, 0);
  EXPECT_EQ(f.stat("dropped-flush"), 4u);
  EXPECT_EQ(f.stat("held"), 0u);
}

TEST(FilterWorkersState, StopsWhileTheStreamingThreadWaits) {
  GatedFilter f("when-busy=block");
  f.push(0);
  f.push(1);
  GstFlowReturn flow = GST_FLOW_OK;
  std::thread other([&] { flow = f.push(2); });
  f.wait_for_stat("received", 3);
  std::thread opener([&] {
    other.join();
    gate().open();
  });
  gst_element_set_state(f.element(), GST_STATE_NULL);
  opener.join();
  EXPECT_EQ(flow, GST_FLOW_FLUSHING);
  EXPECT_EQ(f.stat("held"), 0u);
}

TEST(FilterWorkersState, RestartsAfterAStop) {
  GatedFilter f("workers=2", true);
  for (int round = 0; round < 5; ++round) {
    f.push(0);
    EXPECT_EQ(f.pull(1), Numbers{1});
    f.expect_all_accounted();
    gst_element_set_state(f.element(), GST_STATE_READY);
    EXPECT_EQ(gate().seen().models, 0);
    gst_element_set_state(f.element(), GST_STATE_PLAYING);
    gst_harness_set_src_caps_str(f.get(), kFourFloats);
  }
}

// Flushes at random times: each frame is accounted for, and none is pushed after the flush.
TEST(FilterWorkersState, KeepsCountsAcrossFlushes) {
  for (const char* when_busy : {"block", "drop-old"}) {
    GatedFilter f("workers=3 when-busy=" + std::string(when_busy), true);
    std::vector<float> out;
    for (int i = 0; i < 500; ++i) {
      EXPECT_EQ(f.push(static_cast<float>(i)), GST_FLOW_OK);
      if (i % 7 != 6) continue;
      flush(f);
      for (const float n : f.pull(f.waiting_outside())) {
        EXPECT_GT(n, out.empty() ? 0 : out.back());
        out.push_back(n);
      }
      out.push_back(static_cast<float>(i + 1));  // numbers after the flush are higher
    }
    f.wait_for_stat("held", 0);
    EXPECT_EQ(f.stat("received"), f.stat("consumed") + f.stat("dropped"));
    EXPECT_EQ(f.stat("dropped-error"), 0u);
  }
}

}  // namespace busy_test
}  // namespace weir::test
