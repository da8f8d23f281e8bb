// tensor_filter with workers: concurrent frames, their order, sessions, engine threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/gated_filter_test_support.hpp"
#include "machine/usable_cores.hpp"

namespace weir::test {
namespace workers_test {

using Numbers = std::vector<float>;

TEST(FilterWorkers, RunSeveralFramesAtOnceAndRestoreTheirOrder) {
  GatedFilter f("workers=3");
  for (const float n : {0, 1, 2}) EXPECT_EQ(f.push(n), GST_FLOW_OK);
  gate().wait_for_entered(3);
  EXPECT_EQ(f.stat("workers-busy"), 3u);
  gate().let_go(2);
  gate().let_go(1);
  f.wait_for_stat("workers-busy", 1);
  EXPECT_EQ(f.waiting_outside(), 0u) << "the oldest is in progress";
  gate().let_go(0);
  EXPECT_EQ(f.pull(3), (Numbers{1, 2, 3}));
  f.expect_all_accounted();
}

TEST(FilterWorkers, ShowTheirOccupancy) {
  GatedFilter f("workers=2");
  for (const float n : {0, 1, 2}) f.push(n);
  gate().wait_for_entered(2);
  EXPECT_EQ(f.stat("workers"), 2u);
  EXPECT_EQ(f.stat("workers-busy"), 2u);
  EXPECT_EQ(f.stat("waiting"), 1u);
  EXPECT_EQ(f.stat("bytes-held"), 48u);
  EXPECT_EQ(f.stat("held"), 3u);
  double mean = -1;
  gst_structure_get_double(stats(f.element()).get(), "mean-busy", &mean);
  EXPECT_GT(mean, 0);
  EXPECT_LE(mean, 2);
}

TEST(FilterWorkers, RunOnTheStreamingThreadByDefault) {
  GatedFilter f("", true);
  const auto self = std::this_thread::get_id();
  std::thread::id pushed_by;
  const auto note = [](GstPad*, GstPadProbeInfo*, gpointer data) {
    *static_cast<std::thread::id*>(data) = std::this_thread::get_id();
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(f.get()->sinkpad, GST_PAD_PROBE_TYPE_BUFFER, note, &pushed_by, nullptr);
  EXPECT_EQ(f.push(0), GST_FLOW_OK);
  EXPECT_EQ(pushed_by, self);
  EXPECT_EQ(f.stat("workers"), 1u);
  EXPECT_EQ(f.stat("workers-busy"), 0u);
}

TEST(FilterWorkers, HaveSeparateSessions) {
  GatedFilter f("workers=3");
  EXPECT_EQ(gate().seen().sessions, 3);
  EXPECT_EQ(gate().seen().models, 1);
  for (const float n : {0, 1, 2}) f.push(n);
  gate().wait_for_entered(3);
  EXPECT_EQ(gate().seen().max_in_a_session, 1);
}

TEST(FilterWorkers, ShareASessionThatIsThreadSafe) {
  GatedFilter f("workers=3 custom=thread-safe:1");
  EXPECT_EQ(gate().seen().sessions, 1);
  for (const float n : {0, 1, 2}) f.push(n);
  gate().wait_for_entered(3);
  EXPECT_EQ(gate().seen().max_in_a_session, 3);
}

TEST(FilterWorkers, OpenModelsThatHaveOneSessionEach) {
  {
    GatedFilter f("workers=3 custom=max-sessions:1", true);
    EXPECT_EQ(gate().seen().models, 3);
    EXPECT_EQ(gate().seen().sessions, 3);
    f.push(0);
    EXPECT_EQ(f.pull(1), Numbers{1});
  }
  EXPECT_EQ(gate().seen().models, 0);
  EXPECT_EQ(gate().seen().sessions, 0);
}

TEST(FilterWorkers, AreRejectedForAStatefulModel) {
  gate().reset();
  const std::string line =
      "tensor_filter framework=gated custom=stateful:1 model=" + any_model_file();
  const std::string error = start_error(line + " workers=2");
  EXPECT_SAYS(error, "WEIR-1004: the model keeps state from frame to frame");
  EXPECT_SAYS(error, "offered: workers=2");
  EXPECT_EQ(start_error(line), "");
}

TEST(FilterWorkers, KeepEventsInTheirPlace) {
  GatedFilter f("workers=2");
  std::vector<std::string> order;
  const auto note = [](GstPad*, GstPadProbeInfo* info, gpointer data) {
    auto* list = static_cast<std::vector<std::string>*>(data);
    if (info->type & GST_PAD_PROBE_TYPE_BUFFER)
      list->emplace_back("frame");
    else if (const auto* event = GST_PAD_PROBE_INFO_EVENT(info);
             GST_EVENT_TYPE(event) >= GST_EVENT_EOS)
      list->emplace_back(GST_EVENT_TYPE_NAME(event));
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(
      f.get()->sinkpad,
      GstPadProbeType(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM), note,
      &order, nullptr);
  f.push(0);
  gst_harness_push_event(f.get(), gst_event_new_gap(0, 1));
  f.push(1);
  gst_harness_push_event(f.get(), gst_event_new_eos());
  gate().wait_for_entered(2);
  gate().let_go(1);
  gate().let_go(0);
  f.pull(2);
  f.wait_for_stat("workers-busy", 0);
  EXPECT_EQ(order, (std::vector<std::string>{"frame", "gap", "frame", "eos"}));
}

TEST(FilterWorkers, FinishTheFramesOfTheOldCapsBeforeTheNew) {
  GatedFilter f("workers=2");
  f.push(0);
  f.push(1);
  std::thread opener([] {
    gate().wait_for_entered(2);
    gate().open();
  });
  gst_harness_set_src_caps_str(f.get(),
                               "other/tensors,format=static,num_tensors=1,"
                               "dimensions=(string)4:2,types=float32,framerate=30/1");
  opener.join();
  EXPECT_EQ(f.waiting_outside(), 2u);
  gst_harness_push(f.get(), frame<float>({2, 2, 2, 2, 2, 2, 2, 2}));
  EXPECT_EQ(f.pull(3), (Numbers{1, 2, 3}));
  f.expect_all_accounted();
}

TEST(FilterWorkers, FollowTheShapesOfAFlexibleStream) {
  gate().reset(true);
  auto h = make_harness("tensor_filter workers=3 framework=gated model=" + any_model_file(),
                        "other/tensors,format=flexible,framerate=30/1");
  for (uint32_t i = 0; i < 30; ++i) {
    const uint32_t rows = 1 + i % 3;
    std::vector<float> in(32 + 4 * rows, static_cast<float>(i));
    const uint32_t head[] = {0xFEEDCCED, 0xDE001000, 7, 4, rows};
    std::memset(in.data(), 0, 128);
    std::memcpy(in.data(), head, sizeof head);
    const uint32_t format_and_media[] = {1, 4};
    std::memcpy(in.data() + 19, format_and_media, 8);
    EXPECT_EQ(gst_harness_push(h.get(), frame(in)), GST_FLOW_OK);
  }
  for (uint32_t i = 0; i < 30; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    const auto result = values<float>(out.get());
    ASSERT_EQ(result.size(), 32 + 4 * (1 + i % 3));
    EXPECT_EQ(result.back(), static_cast<float>(i + 1));
  }
}

TEST(FilterWorkers, AnswerADrainQueryWhenAllFramesArePushed) {
  GatedFilter f("workers=2");
  f.push(0);
  f.push(1);
  std::thread opener([] {
    gate().wait_for_entered(2);
    gate().open();
  });
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_drain());
  gst_pad_peer_query(f.get()->srcpad, query.get());
  EXPECT_EQ(f.waiting_outside(), 2u);
  opener.join();
}

TEST(FilterWorkers, AnswerADrainQueryAfterTheyHaveStopped) {
  GatedFilter f("workers=2", true);
  f.push(0);
  gst_element_set_state(f.element(), GST_STATE_READY);
  const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(f.element(), "sink"));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_drain());
  gst_pad_query(sink.get(), query.get());
  EXPECT_EQ(stat(f.element(), "held"), 0u);
}

int share(int workers) {
  return std::max(1, usable_cores() / workers);
}

TEST(FilterThreads, AreChosenByTheEngineForASingleFilter) {
  GatedFilter f("");
  EXPECT_EQ(gate().seen().threads_wanted, std::vector<int>{0});
}

TEST(FilterThreads, AreSharedAmongWorkers) {
  GatedFilter f("workers=2 custom=max-sessions:1");
  EXPECT_EQ(gate().seen().threads_wanted, std::vector<int>(2, share(2)));
  int threads = -1;
  gst_structure_get_int(stats(f.element()).get(), "threads", &threads);
  EXPECT_EQ(threads, share(2)) << "stats show it";
}

TEST(FilterThreads, AreAsManyAsRequested) {
  GatedFilter f("workers=2 threads=7");
  EXPECT_EQ(gate().seen().threads_wanted, std::vector<int>{7});
}

TEST(FilterThreads, AreSharedAmongTheFiltersOfAPipeline) {
  gate().reset();
  const std::string filter = "tensor_filter framework=gated model=" + any_model_file();
  const auto pipeline = lone_element(filter + " " + filter + " " + filter + " custom=NumThreads:1");
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  auto wanted = gate().seen().threads_wanted;
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  std::sort(wanted.begin(), wanted.end());
  const int each = std::max(1, (usable_cores() - 1) / 2);
  std::vector<int> expected{1, each, each};
  EXPECT_EQ(wanted, expected);
}

}  // namespace workers_test
}  // namespace weir::test
