// invoke-async: an engine that answers on its own thread, with any number of outputs for a frame.
// The engine is tests/support/async_engine.cpp: output k of a frame x is x + k.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/check/gsttestclock.h>

#include <thread>

#include "elements/tensor_filter/async_filter_test_support.hpp"

namespace async_test {

using namespace weir::test;
using namespace weir::test::async;

TEST(TensorFilterAsync, PushesAnyNumberOfOutputsForAFrame) {
  for (const char* custom : {"in-flight:1", "in-flight:3", "in-flight:1,inline:1"}) {
    auto h = harness(custom);
    End end(h);
    std::vector<float> expected;
    for (int i = 0; i < 30; ++i) {
      const float x = static_cast<float>(i % 5);
      for (int k = 0; k < i % 5; ++k) expected.push_back(x + static_cast<float>(k));
      ASSERT_EQ(push(h, x), GST_FLOW_OK);
    }
    gst_harness_push_event(h.get(), gst_event_new_eos());
    end.wait();
    std::vector<float> out;
    while (gst_harness_buffers_in_queue(h.get()) > 0) out.push_back(pull(h));
    EXPECT_EQ(out, expected) << custom << ": EOS follows all of them";
    EXPECT_EQ(stat(h, kFilter, "consumed"), 30u);
    EXPECT_EQ(stat(h, kFilter, "pushed"), expected.size());
    EXPECT_EQ(stat(h, kFilter, "invokes"), 30u);
    expect_sums(h);
    EXPECT_SAYS(caps_text(h), "other/tensor,") << "sizes are known, so the stream is static";
  }
}

TEST(TensorFilterAsync, KeepsTheOrderOfFramesThatEndOutOfOrder) {
  auto h = harness("outputs:2,in-flight:4,reverse:4");
  std::vector<float> expected, out;
  for (int i = 0; i < 12; ++i) {
    const auto x = static_cast<float>(10 * i);
    expected.insert(expected.end(), {x, x + 1});
    ASSERT_EQ(push(h, x), GST_FLOW_OK);
  }
  for (size_t i = 0; i < expected.size(); ++i) out.push_back(pull(h));
  EXPECT_EQ(out, expected);
}

TEST(TensorFilterAsync, CountsFramesByTheReasonForWhichTheyHaveNoResult) {
  for (const char* custom : {"outcomes,in-flight:1", "outcomes,in-flight:4,reverse:4"}) {
    auto h = harness(custom);
    End end(h);
    for (const float x : {1.F, -1.F, -2.F, -2.F, -3.F, -3.F, -3.F, 2.F})
      ASSERT_EQ(push(h, x), GST_FLOW_OK);
    gst_harness_push_event(h.get(), gst_event_new_eos());
    end.wait();
    EXPECT_EQ(stat(h, kFilter, "consumed"), 2u) << custom;
    EXPECT_EQ(stat(h, kFilter, "dropped-late"), 1u) << custom;
    EXPECT_EQ(stat(h, kFilter, "dropped-refused"), 2u) << custom;
    EXPECT_EQ(stat(h, kFilter, "dropped-lost"), 3u) << custom;
    EXPECT_EQ(stat(h, kFilter, "pushed"), 3u) << custom << ": one of 1, two of 2";
    expect_sums(h);
  }
}

TEST(TensorFilterAsync, PushesTheOutputsOfAFrameThatIsLostInTheEnd) {
  auto h = harness("outcomes,outputs:2");
  ASSERT_EQ(push(h, -3), GST_FLOW_OK);
  EXPECT_EQ(pull(h), -3);
  EXPECT_EQ(pull(h), -2);
  expect_sums(h);
  EXPECT_EQ(stat(h, kFilter, "dropped-lost"), 1u);
}

TEST(TensorFilterAsync, CountsAFlushedFrameAsFlushedWhateverItsEnd) {
  auto h = harness("outcomes,until-cancelled,in-flight:2");
  ASSERT_EQ(push(h, -3), GST_FLOW_OK);
  flush(h);
  expect_sums(h);
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 1u);
  EXPECT_EQ(stat(h, kFilter, "dropped-lost"), 0u);
}

TEST(TensorFilterAsync, CopiesTheTimeOfTheFrameToEachOutput) {
  auto h = harness("outputs:2,in-flight:2");
  for (const GstClockTime time : {5 * GST_SECOND, 7 * GST_SECOND}) {
    GstBuffer* in = frame<float>({1, 2, 3, 4}, time, GST_MSECOND);
    GST_BUFFER_OFFSET(in) = 42;
    ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  }
  for (const GstClockTime time : {5, 5, 7, 7}) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), time * GST_SECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), GST_MSECOND);
    EXPECT_EQ(GST_BUFFER_OFFSET(out.get()), 42u);
  }
}

TEST(TensorFilterAsync, KeepsEventsInTheirPlaceBetweenFrames) {
  auto h = harness("outputs:2,in-flight:2,reverse:2");
  std::vector<std::string> order;
  const auto note = [](GstPad*, GstPadProbeInfo* info, gpointer data) {
    auto* list = static_cast<std::vector<std::string>*>(data);
    if (info->type & GST_PAD_PROBE_TYPE_BUFFER)
      list->emplace_back("output");
    else if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_CUSTOM_DOWNSTREAM)
      list->emplace_back("event");
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(
      h->sinkpad, GstPadProbeType(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM),
      note, &order, nullptr);
  End end(h);
  push(h, 0);
  gst_harness_push_event(h.get(), gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM,
                                                       gst_structure_new_empty("between")));
  push(h, 1);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  end.wait();
  EXPECT_EQ(order, (std::vector<std::string>{"output", "output", "event", "output", "output"}));
}

TEST(TensorFilterAsync, SendsNewCapsAfterTheFramesBefore) {
  auto h = harness("outputs:1,in-flight:2");
  push(h, 1);
  gst_harness_set_src_caps_str(h.get(), tensors("float32", "4:2").c_str());
  ASSERT_EQ(gst_harness_push(h.get(), frame<float>({5, 5, 5, 5, 6, 6, 6, 6})), GST_FLOW_OK);
  EXPECT_EQ(pull(h), 1.f);
  EXPECT_EQ(pull(h), 5.f);
}

TEST(TensorFilterAsync, AllowsAnotherSizeForEachOutput) {
  for (const char* dynamic : {"invoke-dynamic=true", ""}) {
    auto h = harness("outputs:3,dynamic:1", dynamic);
    push(h, 1);
    for (uint32_t rows = 1; rows <= 3; ++rows) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      const auto words = values<uint32_t>(out.get());
      ASSERT_EQ(words.size(), 32 + 4 * rows);
      EXPECT_EQ(words[4], rows);
      EXPECT_EQ(words[19], *dynamic ? 1u : 0u) << "the header's format";
    }
    EXPECT_SAYS(caps_text(h), "format=(string)flexible");
  }
}

// ---- Errors ----------------------------------------------------------------------------------

TEST(TensorFilterAsync, RejectsASynchronousEngine) {
  std::string text = start_error(filter("synchronous:1"));
  EXPECT_SAYS(text, "WEIR-3005: the engine supports only synchronous invokes of this model");
  EXPECT_SAYS(text, "offered: invoke-async=true with framework=fake-async");
  EXPECT_SAYS(text, "fix: tensor_filter invoke-async=false");
  const std::string path = testing::TempDir() + "weir_async_model.bin";
  text = start_error("tensor_filter framework=fake invoke-async=true model=" + path);
  EXPECT_SAYS(text, "with framework=fake");
}

TEST(TensorFilterAsync, RejectsCombinationsOfInputsAndOutputs) {
  const std::string text = start_error(filter("", "output-combination=o0,i0"));
  EXPECT_SAYS(
      text,
      "WEIR-1004: output-combination cannot contain inputs when the engine answers asynchronously");
  EXPECT_SAYS(text, "offered: i0");
  EXPECT_SAYS(text, "fix: tensor_filter invoke-async=true output-combination=o0");
  EXPECT_EQ(start_error(filter("", "output-combination=o0")), "");
}

TEST(TensorFilterAsync, RejectsBatching) {
  const std::string text = start_error(filter("", "batch-size=4"));
  EXPECT_SAYS(text,
              "WEIR-3013: frames cannot be batched for an engine that answers asynchronously");
  EXPECT_SAYS(text, "offered: batch-size=4 with invoke-async=true");
  EXPECT_SAYS(text, "fix: tensor_filter invoke-async=true batch-size=1");
}

TEST(TensorFilterAsync, FailsTheStreamWithTheEnginesError) {
  auto h = harness("outputs:3,fail-at:1,in-flight:3");
  Errors errors(h);
  EXPECT_EQ(push(h, 0), GST_FLOW_OK);
  EXPECT_EQ(push(h, 10), GST_FLOW_OK);
  for (const float expected : {0.f, 1.f, 2.f, 10.f}) EXPECT_EQ(pull(h), expected);
  EXPECT_SAYS(await(errors), "WEIR-3006: the engine failed on a frame");
  EXPECT_EQ(errors.next(), "") << "once";
  EXPECT_EQ(push(h, 20), GST_FLOW_ERROR);
  EXPECT_EQ(stat(h, kFilter, "pushed"), 4u) << "three, and one before the failure";
  EXPECT_EQ(stat(h, kFilter, "dropped-error"), 2u);
  expect_sums(h);
}

TEST(TensorFilterAsync, FailsTheStreamWhenAFrameIsRejected) {
  auto h = harness("outputs:1,refuse-at:1");
  Errors errors(h);
  EXPECT_EQ(push(h, 0), GST_FLOW_OK);
  EXPECT_EQ(pull(h), 0.f);
  EXPECT_EQ(push(h, 1), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "ordered to refuse");
  expect_sums(h);
}

TEST(TensorFilterAsync, RejectsInvalidOutputs) {
  struct Case {
    const char* custom;
    const char* message;
  };
  for (const auto& [custom, message] :
       {Case{"other-shape:1", "the model changed the size of an output"},
        Case{"wrong-size:1", "the size of the engine's output does not match its shape"},
        Case{"no-memory:1", "the engine returned no memory for an output"}}) {
    auto h = harness(std::string("outputs:2,") + custom);
    Errors errors(h);
    End end(h);
    push(h, 1);
    gst_harness_push_event(h.get(), gst_event_new_eos());
    end.wait();
    EXPECT_SAYS(await(errors), message);
    EXPECT_EQ(stat(h, kFilter, "pushed"), 0u);
    EXPECT_EQ(stat(h, kFilter, "dropped-error"), 1u);
    expect_sums(h);
  }
}

TEST(TensorFilterAsync, RejectsAFrameOfTheWrongSize) {
  auto h = harness("outputs:1");
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1})), GST_FLOW_ERROR);
  expect_sums(h);
}

// ---- Flushes and the end ---------------------------------------------------------------------

// The engine answers cancelled frames with an output, which is ignored.
TEST(TensorFilterAsync, IgnoresOutputsOfFramesBeforeAFlush) {
  auto h = harness("outputs:1,in-flight:2,until-cancelled:1");
  push(h, 1);
  push(h, 2);
  EXPECT_EQ(stat(h, kFilter, "held"), 2u);
  flush(h);
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 2u);
  EXPECT_EQ(stat(h, kFilter, "held"), 0u);
  // There is room only after the engine has ended the cancelled frames.
  push(h, 3);
  push(h, 4);
  flush(h);
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 4u);
  EXPECT_EQ(stat(h, kFilter, "pushed"), 0u);
  EXPECT_EQ(gst_harness_buffers_received(h.get()), 0u);
  expect_sums(h);
}

// An engine that never answers blocks a thread that waits for room until the flush.
TEST(TensorFilterAsync, ReleasesAWaitingFrameOnFlush) {
  auto h = harness("outputs:1,in-flight:1,never:1");
  push(h, 1);
  GstFlowReturn flow = GST_FLOW_OK;
  std::thread streaming([&] { flow = push(h, 2); });
  wait_for_stat(h, kFilter, "received", 2);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  streaming.join();
  EXPECT_EQ(flow, GST_FLOW_FLUSHING);
  EXPECT_EQ(stat(h, kFilter, "dropped-flush"), 2u);
  expect_sums(h);
}

TEST(TensorFilterAsync, StopsWhileTheEngineIsBusy) {
  for (const char* custom : {"never:1", "until-cancelled:1", "reverse:5"}) {
    auto h = harness(std::string("outputs:1,in-flight:8,") + custom);
    for (int i = 0; i < 3; ++i) ASSERT_EQ(push(h, 1), GST_FLOW_OK);
    const auto element = find_element(h, kFilter);
    gst_element_set_state(element.get(), GST_STATE_NULL);
    EXPECT_EQ(stat(element.get(), "dropped-flush"), 3u) << custom;
    EXPECT_EQ(stat(element.get(), "held"), 0u);
  }
}

TEST(TensorFilterAsync, CanRestartAfterAStop) {
  auto h = harness("outputs:1,in-flight:2");
  const auto element = find_element(h, kFilter);
  push(h, 1);
  EXPECT_EQ(pull(h), 1.f);
  gst_element_set_state(element.get(), GST_STATE_READY);
  gst_element_set_state(element.get(), GST_STATE_PLAYING);
  gst_harness_push_event(h.get(), gst_event_new_stream_start("again"));
  gst_harness_set_src_caps_str(h.get(), kFour.c_str());
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  push(h, 2);
  EXPECT_EQ(pull(h), 2.f);
}

// Many frames while another thread flushes: no frame is lost, and nothing blocks.
TEST(TensorFilterAsync, CountsEveryFrameUnderFlushes) {
  auto h = harness("outputs:2,in-flight:4");
  gst_harness_set_drop_buffers(h.get(), TRUE);
  constexpr int kRounds = 30, kFrames = 20;
  for (int round = 0; round < kRounds; ++round) {
    std::thread flusher([&] { gst_harness_push_event(h.get(), gst_event_new_flush_start()); });
    for (int i = 0; i < kFrames; ++i) push(h, 1);
    flusher.join();
    gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
    const auto element = find_element(h, kFilter);
    EXPECT_EQ(stat(element.get(), "held"), 0u);
  }
  expect_sums(h);
}

// ---- Deadlines -------------------------------------------------------------------------------

TEST(TensorFilterAsync, DropsLateFramesBeforeTheEngine) {
  auto h = harness("outputs:1", "deadline=50000000");
  const Unique<GstTestClock, gst_object_unref> clock(gst_harness_get_testclock(h.get()));
  gst_test_clock_set_time(clock.get(), 100 * GST_MSECOND);
  push(h, 1, 10 * GST_MSECOND);
  push(h, 2, 60 * GST_MSECOND);
  End end(h);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  end.wait();
  EXPECT_EQ(pull(h), 2.f);
  EXPECT_EQ(stat(h, kFilter, "dropped-qos"), 1u);
  EXPECT_EQ(stat(h, kFilter, "invokes"), 1u);
}

}  // namespace async_test
