// tensor_mux: waiting threads wake on flush, EOS, release and state changes; late and dead pads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <thread>

#include "elements/tensor_mux/many_inputs_test_support.hpp"

namespace weir::test {
namespace tensor_mux_shutdown_test {

using namespace std::chrono_literals;

struct Two : ManyInputs {
  explicit Two(const std::string& launch) : ManyInputs(launch) {
    add(caps_of_bytes(1).c_str());
    add(caps_of_bytes(1).c_str());
    play();
  }
  std::future<GstFlowReturn> waiting(GstClockTime pts = 0) {
    const guint64 received = stat("received");
    auto push = push_later(0, Bytes{1}, pts);
    wait_for_stat("received", received + 1);
    return push;
  }
  void expect_no_frame_lost() {
    stop();
    EXPECT_EQ(stat("held"), 0u);
    EXPECT_EQ(stat("received"), stat("consumed") + stat("dropped"));
  }
};

constexpr const char* kModes[] = {"nosync", "slowest", "basepad", "refresh"};

std::string with_mode(const char* mode) {
  return std::string("tensor_mux sync-mode=") + mode;
}

TEST(TensorMuxShutdown, EachStateWakesAWaitingThread) {
  for (const char* mode : kModes)
    for (const GstState state : {GST_STATE_READY, GST_STATE_NULL}) {
      Two mux(with_mode(mode));
      auto push = mux.waiting();
      gst_element_set_state(mux.element(), state);
      EXPECT_EQ(push.get(), GST_FLOW_FLUSHING) << mode;
      EXPECT_EQ(mux.stat("dropped-flush"), 1u);
      mux.expect_no_frame_lost();
    }
}

TEST(TensorMuxShutdown, PausedKeepsAThreadWaiting) {
  Two mux("tensor_mux");
  auto push = mux.waiting();
  gst_element_set_state(mux.element(), GST_STATE_PAUSED);
  EXPECT_EQ(mux.push(1, Bytes{2}, 0), GST_FLOW_OK);
  EXPECT_EQ(push.get(), GST_FLOW_OK);
}

TEST(TensorMuxShutdown, PlaysAgainAfterEachState) {
  Two mux("tensor_mux");
  for (int round = 0; round < 3; ++round) {
    auto push = mux.waiting();
    gst_element_set_state(mux.element(), round == 1 ? GST_STATE_NULL : GST_STATE_READY);
    EXPECT_EQ(push.get(), GST_FLOW_FLUSHING);
    mux.play();
    EXPECT_EQ(mux.stat("received"), 0u);
    for (size_t i = 0; i < 2; ++i) {
      gst_pad_set_active(mux.get_source(i), FALSE);
      gst_pad_set_active(mux.get_source(i), TRUE);
      mux.event(i, gst_event_new_stream_start("again"));
      mux.set_caps(i, caps_of_bytes(1).c_str());
    }
    mux.push_all({{1}, {2}}, 0);
    EXPECT_EQ(mux.buffers().size(), static_cast<size_t>(round) + 1);
  }
}

TEST(TensorMuxShutdown, RemovalWakesTheThreadOfThePad) {
  for (const char* mode : kModes) {
    Two mux(with_mode(mode));
    auto push = mux.waiting();
    mux.remove(0);
    EXPECT_EQ(push.get(), GST_FLOW_FLUSHING) << mode;
    EXPECT_EQ(mux.push(1, Bytes{2}, 0), GST_FLOW_OK);
    mux.expect_no_frame_lost();
  }
}

TEST(TensorMuxShutdown, DeactivationWakesTheThreadOfThePad) {
  Two mux("tensor_mux");
  auto push = mux.waiting();
  gst_pad_set_active(mux.get_sink(0), FALSE);
  EXPECT_EQ(push.get(), GST_FLOW_FLUSHING);
}

TEST(TensorMuxShutdown, FlushWakesThreadsAndDropsFrames) {
  for (const char* mode : kModes) {
    Two mux(with_mode(mode));
    auto push = mux.waiting(1000);
    mux.event(0, gst_event_new_flush_start());
    EXPECT_EQ(push.get(), GST_FLOW_FLUSHING) << mode;
    mux.event(1, gst_event_new_flush_start());
    mux.event(1, gst_event_new_flush_stop(TRUE));
    mux.event(0, gst_event_new_flush_stop(TRUE));
    EXPECT_EQ(mux.events(GST_EVENT_FLUSH_START).size(), 1u);
    EXPECT_EQ(mux.events(GST_EVENT_FLUSH_STOP).size(), 1u);
    for (size_t i = 0; i < 2; ++i) mux.set_caps(i, caps_of_bytes(1).c_str());
    mux.push_all({{1}, {2}}, 5);
    ASSERT_EQ(mux.buffers().size(), 1u) << mode;
    EXPECT_EQ(GST_BUFFER_PTS(mux.buffers()[0].get()), 5u);
    mux.expect_no_frame_lost();
  }
}

TEST(TensorMuxShutdown, AFlushStartsANewSegment) {
  Two mux("tensor_mux");
  mux.push_all({{1}, {2}}, 100);
  for (size_t i = 0; i < 2; ++i) mux.event(i, gst_event_new_flush_start());
  for (size_t i = 0; i < 2; ++i) mux.event(i, gst_event_new_flush_stop(TRUE));
  for (size_t i = 0; i < 2; ++i) mux.set_caps(i, caps_of_bytes(1).c_str());
  mux.push_all({{3}, {4}}, 40);
  const auto segments = mux.events(GST_EVENT_SEGMENT);
  ASSERT_EQ(segments.size(), 2u);
  GstSegment segment;
  gst_event_copy_segment(segments[1].get(), &segment);
  EXPECT_EQ(segment.start, 40u);
}

TEST(TensorMuxShutdown, ReleasingAFlushingPadEndsTheFlush) {
  Two mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.push_all({{1}, {2}, {3}}, 100);
  mux.event(2, gst_event_new_flush_start());
  mux.remove(2);
  EXPECT_EQ(mux.events(GST_EVENT_FLUSH_STOP).size(), 1u);
  mux.push_all({{4}, {5}}, 140);
  mux.wait_for_stat("pushed", 2);  // a release makes outputs on another thread too
  EXPECT_EQ(mux.buffers().size(), 2u);
  EXPECT_EQ(mux.events(GST_EVENT_SEGMENT).size(), 2u) << "a flush removes the segment";
}

// Of many tags before the stream starts, the newest are pushed in order.
TEST(TensorMux, KeepsABoundedNumberOfTagsUntilItsStreamBegins) {
  Two mux("tensor_mux");
  constexpr guint kTags = 1000;
  for (guint i = 1; i <= kTags; ++i)
    mux.event(0, gst_event_new_tag(gst_tag_list_new(GST_TAG_BITRATE, i, nullptr)));
  mux.push_all({{1}, {2}}, 100);
  const auto tags = mux.events(GST_EVENT_TAG);
  EXPECT_LE(tags.size(), 100u);
  ASSERT_FALSE(tags.empty());
  for (size_t i = 0; i < tags.size(); ++i) {
    GstTagList* list = nullptr;
    guint bitrate = 0;
    gst_event_parse_tag(tags[i].get(), &list);
    ASSERT_TRUE(gst_tag_list_get_uint(list, GST_TAG_BITRATE, &bitrate));
    EXPECT_EQ(bitrate, kTags - tags.size() + i + 1);
  }
}

TEST(TensorMuxShutdown, TheEndOfOnePadEndsTheStream) {
  for (const char* mode : {"nosync", "slowest", "basepad"}) {
    Two mux(with_mode(mode));
    auto push = mux.waiting();
    mux.event(1, gst_event_new_eos());
    EXPECT_EQ(mux.events(GST_EVENT_EOS).size(), 1u) << mode;
    push.get();
    EXPECT_EQ(mux.push(0, Bytes{1}, 10), GST_FLOW_EOS);
    EXPECT_EQ(mux.stat("dropped-eos"), 2u);
    mux.expect_no_frame_lost();
  }
}

TEST(TensorMuxShutdown, RefreshContinuesUntilTheLastPadEnds) {
  Two mux("tensor_mux sync-mode=refresh");
  mux.push_all({{1}, {2}}, 0);
  mux.event(1, gst_event_new_eos());
  EXPECT_EQ(mux.push(0, Bytes{3}, 10), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(1).get()), (std::vector<Bytes>{{3}, {2}}));
  EXPECT_TRUE(mux.events(GST_EVENT_EOS).empty());
  mux.event(0, gst_event_new_eos());
  EXPECT_EQ(mux.events(GST_EVENT_EOS).size(), 1u);
  mux.expect_no_frame_lost();
}

TEST(TensorMuxShutdown, RefreshDoesNotWaitOnceAllPadsHaveFrames) {
  Two mux("tensor_mux sync-mode=refresh");
  mux.push_all({{1}, {2}}, 0);
  for (uint8_t i = 0; i < 5; ++i) EXPECT_EQ(mux.push(0, Bytes{i}, 10 + i), GST_FLOW_OK);
  EXPECT_EQ(mux.buffers().size(), 6u);
  EXPECT_EQ(read_memories(mux.buffers().at(5).get()), (std::vector<Bytes>{{4}, {2}}));
}

TEST(TensorMuxShutdown, MaxWaitLimitsTheWaitForASilentPad) {
  for (const char* mode : kModes) {
    Two mux(with_mode(mode) + " max-wait=1000000");
    auto push = mux.push_later(0, Bytes{1}, 0);
    mux.push(1, Bytes{2}, 0);
    push.get();
    for (uint8_t i = 0; i < 5; ++i) EXPECT_EQ(mux.push(0, Bytes{i}, 10 + i), GST_FLOW_OK) << mode;
    const auto out = mux.buffers();
    ASSERT_GE(out.size(), 5u) << mode;
    EXPECT_EQ(read_memories(out.back().get()), (std::vector<Bytes>{{4}, {2}})) << mode;
    mux.expect_no_frame_lost();
  }
}

TEST(TensorMuxShutdown, ASilentPadIsCountedAndCanReturn) {
  Two mux("tensor_mux max-wait=1000000");
  EXPECT_EQ(mux.push(0, Bytes{1}, 0), GST_FLOW_OK);  // dropped: the other inputs have no match
  EXPECT_EQ(mux.stat("pads-missed"), 1u);
  EXPECT_TRUE(mux.buffers().empty());
  g_object_set(mux.element(), "max-wait", guint64{0}, nullptr);
  auto push = mux.push_later(1, Bytes{2}, 10);
  mux.wait_for_stat("received", 2);
  EXPECT_EQ(mux.push(0, Bytes{3}, 10), GST_FLOW_OK);
  push.get();
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()), (std::vector<Bytes>{{3}, {2}}));
  mux.expect_no_frame_lost();
}

TEST(TensorMuxShutdown, AGapReleasesTheOtherPads) {
  Two mux("tensor_mux");
  auto push = mux.waiting(0);
  mux.event(1, gst_event_new_gap(0, 50));
  EXPECT_EQ(push.get(), GST_FLOW_OK);
  EXPECT_TRUE(mux.buffers().empty());
  auto next = mux.push_later(0, Bytes{5}, 50);
  EXPECT_EQ(mux.push(1, Bytes{6}, 50), GST_FLOW_OK);
  EXPECT_EQ(next.get(), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()), (std::vector<Bytes>{{5}, {6}}));
  mux.expect_no_frame_lost();
}

// Like a tensor_crop that finds no regions: only GAP events, which nosync and basepad cannot use.
TEST(TensorMuxShutdown, MaxWaitLimitsTheWaitForAPadWithOnlyGaps) {
  for (const char* mode : {"nosync", "slowest", "basepad"}) {
    Two mux(with_mode(mode) + " max-wait=1000000");
    for (uint8_t i = 0; i < 5; ++i) {
      mux.event(1, gst_event_new_gap(10 * i, 10));
      EXPECT_EQ(mux.push(0, Bytes{i}, 10 * i), GST_FLOW_OK) << mode;
    }
    EXPECT_TRUE(mux.buffers().empty()) << mode;
    g_object_set(mux.element(), "max-wait", guint64{0}, nullptr);
    auto back = mux.push_later(1, Bytes{8}, 60);
    mux.wait_for_stat("received", 6);
    EXPECT_EQ(mux.push(0, Bytes{7}, 60), GST_FLOW_OK) << mode;
    EXPECT_EQ(back.get(), GST_FLOW_OK) << mode;
    ASSERT_EQ(mux.buffers().size(), 1u) << mode;
    EXPECT_EQ(read_memories(mux.buffers()[0].get()), (std::vector<Bytes>{{7}, {8}})) << mode;
    mux.expect_no_frame_lost();
  }
}

TEST(TensorMuxShutdown, DropsBackwardsTimesIfConfigured) {
  Two mux("tensor_mux on-backwards-time=drop");
  mux.push_all({{1}, {2}}, 50);
  EXPECT_EQ(mux.push(0, Bytes{3}, 40), GST_FLOW_OK);
  EXPECT_EQ(mux.stat("times-backwards"), 1u);
  EXPECT_EQ(mux.stat("dropped-time"), 1u);
  const std::string warning = mux.warning();
  EXPECT_SAYS(warning, "WEIR-2008");
  EXPECT_SAYS(warning, "0:00:00.000000040 on sink_0");
  EXPECT_SAYS(warning, "at least 0:00:00.000000050");
  mux.push_all({{4}, {5}}, 60);
  EXPECT_EQ(mux.buffers().size(), 2u);
  mux.expect_no_frame_lost();
}

TEST(TensorMuxShutdown, ARestartedStreamContinues) {
  Two mux("tensor_mux");
  for (GstClockTime loop = 0; loop < 2; ++loop) {
    auto other = std::async(std::launch::async, [&] {
      for (GstClockTime t = 0; t < 10; ++t) mux.push(1, Bytes{1}, t * 10);
    });
    for (GstClockTime t = 0; t < 10; ++t)
      if (mux.push(0, Bytes{1}, t * 10) != GST_FLOW_OK) break;
    if (loop == 1) mux.event(0, gst_event_new_eos());
    other.get();
  }
  EXPECT_GE(mux.buffers().size(), 17u);
  EXPECT_EQ(GST_BUFFER_PTS(mux.buffers().back().get()), 90u);
  EXPECT_GE(mux.stat("times-backwards"), 2u);
  mux.expect_no_frame_lost();
}

TEST(TensorMuxShutdown, AnswersLatencyFromTheLiveInputs) {
  Two mux("tensor_mux max-wait=7");
  struct Latency {
    gboolean live;
    GstClockTime min, max;
  };
  static const Latency latencies[] = {{TRUE, 10, 100}, {FALSE, 500, 600}, {TRUE, 20, 60}};
  mux.add(caps_of_bytes(1).c_str());
  for (size_t i = 0; i < 3; ++i) {
    gst_pad_set_element_private(mux.get_source(i), const_cast<Latency*>(&latencies[i]));
    gst_pad_set_query_function(mux.get_source(i), [](GstPad* pad, GstObject*, GstQuery* query) {
      const auto* a = static_cast<const Latency*>(gst_pad_get_element_private(pad));
      gst_query_set_latency(query, a->live, a->min, a->max);
      return gboolean{TRUE};
    });
  }
  const gst::Unique<GstQuery, gst_query_unref> query(gst_query_new_latency());
  ASSERT_TRUE(gst_pad_peer_query(mux.sink(), query.get()));
  gboolean live = FALSE;
  GstClockTime min = 0, max = 0;
  gst_query_parse_latency(query.get(), &live, &min, &max);
  EXPECT_TRUE(live);
  EXPECT_EQ(min, 27u);
  EXPECT_EQ(max, 67u);
}

TEST(TensorMuxShutdown, AllowsALateDownstreamLink) {
  Two mux("tensor_mux sync-mode=refresh");
  mux.push_all({{1}, {2}}, 0);
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(mux.element(), "src"));
  gst_pad_unlink(source.get(), mux.sink());
  EXPECT_EQ(mux.push(0, Bytes{3}, 10), GST_FLOW_NOT_LINKED);
  gst_pad_link(source.get(), mux.sink());
  EXPECT_EQ(mux.push(1, Bytes{4}, 20), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(1).get()), (std::vector<Bytes>{{3}, {4}}));
}

TEST(TensorMuxShutdown, DownstreamErrorsReachEveryPad) {
  Two mux("tensor_mux");
  gst_pad_set_chain_function(mux.sink(), [](GstPad*, GstObject*, GstBuffer* buffer) {
    gst_buffer_unref(buffer);
    return GST_FLOW_ERROR;
  });
  auto first = mux.push_later(0, Bytes{1}, 0), second = mux.push_later(1, Bytes{1}, 0);
  first.get();
  second.get();
  EXPECT_EQ(mux.push(0, Bytes{1}, 10), GST_FLOW_ERROR);
  EXPECT_EQ(mux.push(1, Bytes{1}, 10), GST_FLOW_ERROR);
}

// Holds events of some types at a pad until it is opened.
class HeldEvent {
 public:
  HeldEvent(GstPad* pad, GstEventType type) : pad_(Ref<GstPad>::share(pad)), type_(type) {
    const auto mask =
        GstPadProbeType(GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM | GST_PAD_PROBE_TYPE_EVENT_FLUSH);
    id_ = gst_pad_add_probe(pad, mask, hold, this, nullptr);
  }
  HeldEvent(const HeldEvent&) = delete;
  HeldEvent& operator=(const HeldEvent&) = delete;
  ~HeldEvent() {
    open();
    gst_pad_remove_probe(pad_.get(), id_);
  }
  void wait() { came_.get_future().wait(); }
  void open() {
    if (!std::exchange(opened_, true)) open_.set_value();
  }

 private:
  static GstPadProbeReturn hold(GstPad*, GstPadProbeInfo* info, gpointer data) {
    auto* self = static_cast<HeldEvent*>(data);
    if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == self->type_) {
      self->came_.set_value();
      self->open_.get_future().wait();
    }
    return GST_PAD_PROBE_OK;
  }
  const Ref<GstPad> pad_;
  const GstEventType type_;
  gulong id_ = 0;
  bool opened_ = false;
  std::promise<void> came_, open_;
};

TEST(TensorMuxShutdown, ReleasesAPadWhileDownstreamBlocksEos) {
  Two mux("tensor_mux sync-mode=refresh");
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(mux.element(), "src"));
  std::future<void> release;
  HeldEvent end(source.get(), GST_EVENT_EOS);
  mux.event(0, gst_event_new_eos());
  release = std::async(std::launch::async, [&] { mux.remove(1); });
  end.wait();
  const bool released = release.wait_for(kMaxWait) == std::future_status::ready;
  end.open();
  EXPECT_TRUE(released) << "the release waits for downstream";
  release.get();
  EXPECT_TRUE(becomes_true([&] { return mux.events(GST_EVENT_EOS).size() == 1; }, "EOS"));
}

// The pad is released while its FLUSH_START is being pushed downstream.
TEST(TensorMuxShutdown, EndsTheFlushOfAReleasedPadAfterItsStart) {
  Two mux("tensor_mux");
  mux.push_all({{1}, {2}}, 0);
  mux.add(caps_of_bytes(1).c_str());
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(mux.element(), "src"));
  const auto sink = Ref<GstPad>::share(mux.get_sink(2));
  std::future<void> flush, release;
  HeldEvent start(source.get(), GST_EVENT_FLUSH_START);
  flush = std::async(std::launch::async,
                     [&] { gst_pad_send_event(sink.get(), gst_event_new_flush_start()); });
  start.wait();
  release = std::async(std::launch::async, [&] { mux.remove(2); });
  release.wait_for(20ms);  // long enough to send FLUSH_STOP too early
  start.open();
  flush.get();
  release.get();
  const auto names = mux.event_names();
  const auto begin = std::find(names.begin(), names.end(), "flush-start");
  ASSERT_NE(begin, names.end());
  EXPECT_NE(std::find(begin, names.end(), "flush-stop"), names.end()) << "after flush-start";
  mux.push_all({{3}, {4}}, 40);
  mux.wait_for_stat("pushed", 2);
  EXPECT_EQ(mux.buffers().size(), 2u);
}

// A sanitizer also detects use of the freed pad.
TEST(TensorMuxShutdown, SurvivesAFlushWhileThePadIsReleased) {
  Two mux("tensor_mux");
  for (uint8_t round = 0; round < 100; ++round) {
    mux.add(caps_of_bytes(1).c_str());
    const auto sink = Ref<GstPad>::share(mux.get_sink(2 + round));
    std::atomic<int> ready = 0;
    const auto meet = [&ready] {
      ++ready;
      return becomes_true([&] { return ready == 2; }, "both threads");
    };
    std::thread flush([&] {
      EXPECT_TRUE(meet());
      gst_pad_send_event(sink.get(), gst_event_new_flush_start());
    });
    EXPECT_TRUE(meet());
    mux.remove(2 + round);
    flush.join();
    mux.push_all({{1}, {2}}, 40 * round);
    ASSERT_EQ(mux.buffers().size(), size_t{round} + 1) << "the output still flushes";
  }
}

}  // namespace tensor_mux_shutdown_test
}  // namespace weir::test
