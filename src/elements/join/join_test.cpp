// join driven by test pads: which branch is forwarded, repeated events, errors, and no deadlocks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <functional>
#include <future>
#include <optional>
#include <thread>

#include "elements/tests/closed_pad_test_support.hpp"
#include "elements/tests/element_test_support.hpp"

namespace join_test {

using namespace weir::test;
using namespace std::chrono_literals;

constexpr char kCaps[] =
    "other/tensors,format=static,num_tensors=1,dimensions=1,types=uint8,"
    "framerate=30/1";

// A join whose branches are source pads of the test.
class JoinTest : public ::testing::Test {
 protected:
  void SetUp() override {
    h_ = Harness{gst_harness_new_with_padnames("join", nullptr, "src")};
    errors_ = std::make_unique<Errors>(h_->element);
  }
  void TearDown() override {
    errors_.reset();
    for (auto& branch : branches_) gst_pad_set_active(branch.get(), FALSE);
    branches_.clear();
    h_.reset();
  }
  GstPad* branch(const char* stream_id, const char* caps = kCaps) {
    auto sink = Ref<GstPad>::adopt(gst_element_request_pad_simple(h_->element, "sink_%u"));
    auto source = Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("out", GST_PAD_SRC))));
    gst_pad_set_active(source.get(), TRUE);
    EXPECT_EQ(gst_pad_link(source.get(), sink.get()), GST_PAD_LINK_OK);
    gst_pad_push_event(source.get(), gst_event_new_stream_start(stream_id));
    give_caps(source.get(), caps);
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    segment.start = branches_.size();
    gst_pad_push_event(source.get(), gst_event_new_segment(&segment));
    branches_.push_back(source);
    return source.get();
  }
  static bool give_caps(GstPad* source, const char* text) {
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text));
    return gst_pad_push_event(source, gst_event_new_caps(caps.get()));
  }
  std::vector<std::string> events() {
    std::vector<std::string> out;
    while (auto e = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h_.get()))) {
      std::string name = GST_EVENT_TYPE_NAME(e.get());
      const gchar* id = nullptr;
      if (name == "stream-start")
        gst_event_parse_stream_start(e.get(), &id), name += " " + std::string(id);
      const GstSegment* segment = nullptr;
      if (name == "segment")
        gst_event_parse_segment(e.get(), &segment), name += " " + std::to_string(segment->start);
      out.push_back(name);
    }
    return out;
  }
  Bytes pulled() {
    Bytes out;
    while (auto b = Ref<GstBuffer>::adopt(gst_harness_try_pull(h_.get())))
      out.push_back(content(b.get())[0]);
    return out;
  }
  std::string active() {
    GstPad* pad = nullptr;
    g_object_get(h_->element, "active-pad", &pad, nullptr);
    const auto owned = Ref<GstPad>::adopt(pad);
    return pad ? GST_OBJECT_NAME(pad) : "";
  }
  guint pads() {
    guint count = 99;
    g_object_get(h_->element, "n-pads", &count, nullptr);
    return count;
  }

  Harness h_;
  std::unique_ptr<Errors> errors_;
  std::vector<Ref<GstPad>> branches_;
};
using Names = std::vector<std::string>;

TEST_F(JoinTest, ForwardsTheDeliveringBranchWithItsStickyEvents) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(pads(), 2u);
  EXPECT_EQ(active(), "");
  EXPECT_EQ(events(), Names{}) << "nothing before the first buffer";
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_EQ(active(), "sink_1");
  EXPECT_EQ(events(), (Names{"stream-start b", "caps", "segment 1"}));
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  EXPECT_EQ(events(), Names{});
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{3})), GST_FLOW_OK);
  EXPECT_EQ(active(), "sink_0");
  EXPECT_EQ(events(), (Names{"stream-start a", "caps", "segment 0"}));
  EXPECT_EQ(pulled(), (Bytes{1, 2, 3}));
  EXPECT_EQ(stat(h_->element, "consumed"), 3u);
  EXPECT_EQ(stat(h_->element, "pushed"), 3u);
  EXPECT_EQ(stat(h_->element, "bytes-copied"), 0u);
}

TEST_F(JoinTest, KeepsTheStreamBetweenBranchesOfTheSameStream) {
  GstPad *a = branch("same"), *b = branch("same");
  gst_pad_push(a, frame(Bytes{1}));
  events();
  gst_pad_push(b, frame(Bytes{2}));
  EXPECT_EQ(events(), (Names{"caps", "segment 1"}));
}

TEST_F(JoinTest, DropsEventsOfInactiveBranches) {
  GstPad *a = branch("a"), *b = branch("b");
  gst_pad_push(a, frame(Bytes{1}));
  events();
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_gap(0, 1)));
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{});
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_gap(0, 1)));
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_eos()));
  EXPECT_EQ(events(), (Names{"gap", "eos"}));
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_EOS);
}

TEST_F(JoinTest, EndsWhenAllBranchesEndWithoutBuffers) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{});
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{"eos"});
}

TEST_F(JoinTest, ReportsBranchesWithDifferentCaps) {
  branch("a");
  branch("b", "other/tensors,format=static,num_tensors=1,dimensions=2,types=uint8,framerate=30/1");
  const std::string error = errors_->next();
  EXPECT_SAYS(error, "WEIR-2001: the branches of join have different caps");
  EXPECT_SAYS(error, "dimensions=(int)2, types=(string)uint8, framerate=(fraction)30/1 on sink_1");
  EXPECT_SAYS(error,
              "dimensions=(int)1, types=(string)uint8, framerate=(fraction)30/1, as on sink_0");
  EXPECT_EQ(gst_pad_push(branches_[1].get(), frame(Bytes{1})), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_EQ(gst_pad_push(branches_[0].get(), frame(Bytes{2})), GST_FLOW_OK);
  EXPECT_EQ(pulled(), Bytes{2});
}

TEST_F(JoinTest, AllowsTheOnlyBranchToChangeCaps) {
  GstPad* a = branch("a");
  gst_pad_push(a, frame(Bytes{1}));
  events();
  EXPECT_TRUE(give_caps(a, "video/x-raw,format=GRAY8,width=1,height=1,framerate=1/1"));
  EXPECT_EQ(events(), Names{"caps"});
  EXPECT_EQ(errors_->next(), "");
}

TEST_F(JoinTest, AllowsBranchesToBeReleasedWhilePlaying) {
  GstPad *a = branch("a"), *b = branch("b");
  gst_pad_push(a, frame(Bytes{1}));
  auto sink = Ref<GstPad>::adopt(gst_pad_get_peer(a));
  gst_element_release_request_pad(h_->element, sink.get());
  EXPECT_EQ(pads(), 1u);
  EXPECT_EQ(active(), "");
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  EXPECT_EQ(active(), "sink_1");
  GstPad* c = branch("c");
  EXPECT_EQ(gst_pad_push(c, frame(Bytes{3})), GST_FLOW_OK);
  EXPECT_EQ(active(), "sink_2");
  EXPECT_EQ(pulled(), (Bytes{1, 2, 3}));
}

TEST_F(JoinTest, AddsABranchWithAGivenName) {
  auto named = Ref<GstPad>::adopt(gst_element_request_pad_simple(h_->element, "sink_0"));
  auto next = Ref<GstPad>::adopt(gst_element_request_pad_simple(h_->element, "sink_%u"));
  ASSERT_TRUE(named && next);
  EXPECT_STREQ(GST_OBJECT_NAME(named.get()), "sink_0");
  EXPECT_STREQ(GST_OBJECT_NAME(next.get()), "sink_1");
}

// Concurrent threads lose no buffers and do not wait for each other.
TEST_F(JoinTest, ForwardsAllFramesOfConcurrentBranches) {
  constexpr int kBranches = 4, kFrames = 500;
  for (int i = 0; i < kBranches; ++i) branch(("branch" + std::to_string(i)).c_str());
  std::vector<std::thread> threads;
  for (auto& source : branches_)
    threads.emplace_back([pad = source.get()] {
      for (int i = 0; i < kFrames; ++i) gst_pad_push(pad, frame(Bytes{7}));
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(pulled().size(), size_t{kBranches} * kFrames);
  EXPECT_EQ(stat(h_->element, "received"), uint64_t{kBranches} * kFrames);
  EXPECT_EQ(stat(h_->element, "held"), 0u);
}

// Two branches: downstream blocks the first, and the second waits for its turn.
class BlockedJoinTest : public JoinTest {
 protected:
  void SetUp() override {
    JoinTest::SetUp();
    blocking_ = branch("a");
    waiting_ = branch("b");
    source_ = Ref<GstPad>::adopt(gst_element_get_static_pad(h_->element, "src"));
    closed_.emplace(source_.get());
    first_ = push_later(blocking_, 1);
    closed_->wait_until_one_is_held();
    second_ = push_later(waiting_, 2);
    EXPECT_TRUE(wait_for_stat(h_->element, "received", 2));
  }
  void TearDown() override {
    closed_.reset();  // both threads return
    if (first_.valid()) first_.get();
    if (second_.valid()) second_.get();
    source_ = {};
    JoinTest::TearDown();
  }
  static std::future<GstFlowReturn> push_later(GstPad* pad, uint8_t value) {
    return std::async(std::launch::async, [=] { return gst_pad_push(pad, frame(Bytes{value})); });
  }
  template <class T>
  static bool returns(const std::future<T>& call, const char* what) {
    return becomes_true([&] { return call.wait_for(0s) == std::future_status::ready; }, what);
  }
  void expect_that_second_leaves() {
    ASSERT_TRUE(returns(second_, "the thread that waits for its turn"));
    EXPECT_EQ(second_.get(), GST_FLOW_FLUSHING);
    EXPECT_EQ(stat(h_->element, "dropped-flush"), 1u);
  }
  void expect_that_first_is_delivered() {
    closed_->open();
    EXPECT_EQ(first_.get(), GST_FLOW_OK);
    EXPECT_EQ(pulled(), Bytes{1});
    EXPECT_EQ(stat(h_->element, "held"), 0u);
  }

  GstPad *blocking_ = nullptr, *waiting_ = nullptr;
  Ref<GstPad> source_;
  std::optional<ClosedPad> closed_;
  std::future<GstFlowReturn> first_, second_;
};

// docs/compatibility/routing.md 6.10: the branch whose frame arrives becomes active immediately.
TEST_F(BlockedJoinTest, ABranchEosDoesNotEndTheStreamWhileAnotherBranchHasAFrame) {
  EXPECT_TRUE(becomes_true([&] { return active() == "sink_1"; }, "the second branch"));
  auto first_and_end = std::async(std::launch::async, [&] {
    EXPECT_EQ(first_.get(), GST_FLOW_OK);
    return gst_pad_push_event(blocking_, gst_event_new_eos());
  });
  closed_->open();
  EXPECT_TRUE(first_and_end.get());
  EXPECT_EQ(second_.get(), GST_FLOW_OK);
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
  EXPECT_EQ(events(),
            (Names{"stream-start a", "caps", "segment 0", "stream-start b", "caps", "segment 1"}));
  EXPECT_TRUE(gst_pad_push_event(waiting_, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{"eos"});
  EXPECT_EQ(stat(h_->element, "held"), 0u);
}

// The branch that delivered last is active again.
TEST_F(BlockedJoinTest, ABranchWithAFlushedFrameDoesNotEndTheStream) {
  EXPECT_TRUE(becomes_true([&] { return active() == "sink_1"; }, "the second branch"));
  EXPECT_TRUE(gst_pad_push_event(waiting_, gst_event_new_flush_start()));
  expect_that_second_leaves();
  EXPECT_TRUE(gst_pad_push_event(waiting_, gst_event_new_flush_stop(TRUE)));
  EXPECT_EQ(active(), "sink_0");
  expect_that_first_is_delivered();
  events();
  EXPECT_TRUE(gst_pad_push_event(waiting_, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{}) << "the first branch is active";
  EXPECT_TRUE(gst_pad_push_event(blocking_, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{"eos"}) << "once";
}

// The branches of one stream get EOS together, but one queue holds more buffers than the other.
TEST_F(JoinTest, WaitsForFramesOfOtherBranchesWhenTheActiveOneEnds) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  auto end =
      std::async(std::launch::async, [&] { return gst_pad_push_event(b, gst_event_new_eos()); });
  for (uint8_t i = 3; i < 6; ++i) EXPECT_EQ(gst_pad_push(a, frame(Bytes{i})), GST_FLOW_OK);
  EXPECT_TRUE(end.get());
  EXPECT_EQ(pulled(), (Bytes{1, 2, 3, 4, 5}));
  events();
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{"eos"});
}

// As downstream of a closed valve.
TEST_F(JoinTest, EndsWithTheActiveBranchWhenNoOtherSendsBuffers) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{2})), GST_FLOW_OK);
  events();
  auto end =
      std::async(std::launch::async, [&] { return gst_pad_push_event(a, gst_event_new_eos()); });
  EXPECT_TRUE(end.get());
  EXPECT_EQ(events(), Names{"eos"});
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{3})), GST_FLOW_EOS);
  EXPECT_EQ(events(), Names{}) << "this starts no new stream";
  EXPECT_EQ(stat(h_->element, "dropped-eos"), 1u);
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
}

// The other branches can deliver nothing before this event returns.
TEST_F(JoinTest, DoesNotWaitForBranchesFedByTheSameThread) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{2})), GST_FLOW_OK);
  events();
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{"eos"});
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{});
}

// As tensor_filter with workers: caps and segment come from the thread that feeds it, buffers do
// not.
TEST_F(JoinTest, WaitsForABranchThatPushesBuffersFromOtherThreads) {
  GstPad *a = branch("a"), *b = branch("b");
  const auto push_a = [a](uint8_t value) { return gst_pad_push(a, frame(Bytes{value})); };
  EXPECT_EQ(std::async(std::launch::async, push_a, 1).get(), GST_FLOW_OK);
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  auto last = std::async(std::launch::async, [&] {
    EXPECT_TRUE(becomes_true([b] { return GST_PAD_IS_EOS(b); }, "EOS of the active branch"));
    return push_a(3);
  });
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_eos()));
  EXPECT_EQ(last.get(), GST_FLOW_OK);
  EXPECT_EQ(pulled(), (Bytes{1, 2, 3}));
}

TEST_F(JoinTest, ContinuesAfterEosWithABranchThatStartsAStream) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_eos()));
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_eos()));
  events();
  EXPECT_TRUE(gst_pad_push_event(b, gst_event_new_stream_start("again")));
  EXPECT_TRUE(give_caps(b, kCaps));
  EXPECT_TRUE(gst_pad_push_event(b, time_segment()));
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  EXPECT_EQ(events(), (Names{"stream-start again", "caps", "segment 0"}));
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
}

TEST_F(JoinTest, AFlushEndsTheWaitForOtherBranches) {
  GstPad* a = branch("a");
  branch("b");
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_OK);
  events();
  auto end =
      std::async(std::launch::async, [&] { return gst_pad_push_event(a, gst_event_new_eos()); });
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_flush_start()));
  end.get();
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_flush_stop(TRUE)));
  gst_pad_push_event(a, time_segment());
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{2})), GST_FLOW_OK) << "after the flush";
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
}

TEST_F(JoinTest, SendsStoredStickyEventsWhenABranchBecomesActive) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  events();
  gst_pad_push_event(a, gst_event_new_tag(gst_tag_list_new(GST_TAG_TITLE, "a", nullptr)));
  EXPECT_EQ(events(), Names{});
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{3})), GST_FLOW_OK);
  EXPECT_EQ(events(), (Names{"stream-start a", "caps", "segment 0", "tag"}));
}

TEST_F(BlockedJoinTest, ReleasesABlockedBranch) {
  const auto sink = Ref<GstPad>::adopt(gst_pad_get_peer(waiting_));
  const auto release = std::async(
      std::launch::async, [&] { gst_element_release_request_pad(h_->element, sink.get()); });
  const bool released = returns(release, "the release of the pad");
  if (!released) closed_->open();
  ASSERT_TRUE(released);
  expect_that_second_leaves();
  EXPECT_EQ(pads(), 1u);
  EXPECT_EQ(active(), "sink_0");
  expect_that_first_is_delivered();
}

// In PAUSED, for example, downstream accepts no other frame.
TEST_F(BlockedJoinTest, ReleasesTheBranchThatDownstreamBlocks) {
  const auto sink = Ref<GstPad>::adopt(gst_pad_get_peer(blocking_));
  const auto release = std::async(
      std::launch::async, [&] { gst_element_release_request_pad(h_->element, sink.get()); });
  const bool released = returns(release, "the release of the pad");
  closed_->open();
  ASSERT_TRUE(released);
  EXPECT_EQ(first_.get(), GST_FLOW_OK) << "its frame is downstream";
  EXPECT_EQ(second_.get(), GST_FLOW_OK);
  EXPECT_EQ(pads(), 1u);
  EXPECT_EQ(active(), "sink_1");
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
  EXPECT_EQ(stat(h_->element, "held"), 0u);
  EXPECT_NE(gst_pad_push(blocking_, frame(Bytes{3})), GST_FLOW_OK) << "the pad is gone";
}

// The thread of a branch may come back while its pad is released. A new pad may get the address.
TEST_F(BlockedJoinTest, APadAtTheAddressOfAReleasedOneHasNotEnded) {
  auto old = Ref<GstPad>::adopt(gst_pad_get_peer(blocking_));
  std::function<void()> come_back = [&] {
    closed_->open();
    EXPECT_EQ(first_.get(), GST_FLOW_OK);
    EXPECT_TRUE(gst_pad_send_event(old.get(), gst_event_new_eos()));
  };
  g_signal_connect(old.get(), "unlinked", G_CALLBACK(+[](GstPad*, GstPad*, gpointer f) {
                     (*static_cast<std::function<void()>*>(f))();
                   }),
                   &come_back);
  gst_element_release_request_pad(h_->element, old.get());
  EXPECT_EQ(second_.get(), GST_FLOW_OK);
  const auto waiting = Ref<GstPad>::adopt(gst_pad_get_peer(waiting_));
  gst_element_release_request_pad(h_->element, waiting.get());
  GstPad* const third = branch("c");
  events();
  const GstPad* const address = old.get();
  old = {};
  std::vector<Ref<GstPad>> others;
  auto sink = Ref<GstPad>::adopt(gst_element_request_pad_simple(h_->element, "sink_%u"));
  while (sink.get() != address && others.size() < 100) {
    gst_element_release_request_pad(h_->element, sink.get());
    others.push_back(sink);
    sink = Ref<GstPad>::adopt(gst_element_request_pad_simple(h_->element, "sink_%u"));
  }
  if (sink.get() != address) GTEST_SKIP() << "no pad got the address again";
  EXPECT_TRUE(gst_pad_push_event(third, gst_event_new_eos()));
  EXPECT_EQ(events(), Names{});
}

TEST_F(BlockedJoinTest, FlushesABlockedBranch) {
  EXPECT_TRUE(gst_pad_push_event(waiting_, gst_event_new_flush_start()));
  expect_that_second_leaves();
  EXPECT_TRUE(gst_pad_push_event(waiting_, gst_event_new_flush_stop(TRUE)));
  expect_that_first_is_delivered();
  EXPECT_EQ(events(), (Names{"stream-start a", "caps", "segment 0"})) << "no flush downstream";
  gst_pad_push_event(waiting_, time_segment());
  EXPECT_EQ(gst_pad_push(waiting_, frame(Bytes{3})), GST_FLOW_OK) << "after the flush";
  EXPECT_EQ(pulled(), Bytes{3});
}

TEST_F(BlockedJoinTest, DeactivatesABlockedBranch) {
  const auto sink = Ref<GstPad>::adopt(gst_pad_get_peer(waiting_));
  const auto deactivation =
      std::async(std::launch::async, [&] { return gst_pad_set_active(sink.get(), FALSE); });
  const bool returned = returns(deactivation, "the deactivation of the pad");
  if (!returned) closed_->open();
  ASSERT_TRUE(returned);
  expect_that_second_leaves();
  expect_that_first_is_delivered();
}

// A serialized query also waits downstream, for the stream lock that the blocked buffer holds.
TEST_F(JoinTest, ReleasesABranchThatIsBlockedInASerializedQuery) {
  GstPad *a = branch("a"), *b = branch("b");
  const auto requested = Ref<GstPad>::adopt(gst_pad_get_peer(b));
  std::future<GstFlowReturn> first;
  std::future<void> second, release;
  ClosedPad closed(h_->sinkpad);
  first = std::async(std::launch::async, [&] { return gst_pad_push(a, frame(Bytes{1})); });
  closed.wait_until_one_is_held();
  std::atomic<bool> begun = false;
  gst_pad_add_probe(
      requested.get(),
      GstPadProbeType(GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM | GST_PAD_PROBE_TYPE_PUSH),
      +[](GstPad*, GstPadProbeInfo*, gpointer flag) {
        *static_cast<std::atomic<bool>*>(flag) = true;
        return GST_PAD_PROBE_OK;
      },
      &begun, nullptr);
  second = std::async(std::launch::async, [&] {
    const Unique<GstQuery, gst_query_unref> query(gst_query_new_drain());
    gst_pad_peer_query(b, query.get());
  });
  EXPECT_TRUE(becomes_true([&] { return begun.load(); }, "the query"));
  release = std::async(std::launch::async,
                       [&] { gst_element_release_request_pad(h_->element, requested.get()); });
  EXPECT_EQ(release.wait_for(kMaxWait), std::future_status::ready);
  closed.open();
  EXPECT_EQ(first.get(), GST_FLOW_OK);
}

TEST_F(JoinTest, BlocksOtherBranchesWhileTheActiveOneFlushes) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_OK);
  events();
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_flush_start()));
  auto other = std::async(std::launch::async, [&] { return gst_pad_push(b, frame(Bytes{2})); });
  EXPECT_TRUE(wait_for_stat(h_->element, "received", 2));
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_flush_stop(TRUE)));
  EXPECT_EQ(other.get(), GST_FLOW_OK);
  EXPECT_EQ(events(), (Names{"flush-start", "flush-stop", "stream-start b", "caps", "segment 1"}));
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
}

TEST_F(JoinTest, EndsTheFlushOfABranchThatIsReleased) {
  GstPad *a = branch("a"), *b = branch("b");
  EXPECT_EQ(gst_pad_push(a, frame(Bytes{1})), GST_FLOW_OK);
  EXPECT_TRUE(gst_pad_push_event(a, gst_event_new_flush_start()));
  const auto sink = Ref<GstPad>::adopt(gst_pad_get_peer(a));
  gst_element_release_request_pad(h_->element, sink.get());
  EXPECT_EQ(gst_pad_push(b, frame(Bytes{2})), GST_FLOW_OK);
  EXPECT_EQ(pulled(), (Bytes{1, 2}));
}

}  // namespace join_test
