// tensor_reposink in a harness: the frames it passes, when it waits, and what ends the wait.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <future>
#include <thread>

#include "becomes.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir::test {
namespace tensor_reposink_test {

constexpr char kByte[] = "other/tensor,dimension=(string)2,type=(string)uint8,framerate=30/1";

std::string slot(int index) {
  return "tensor_reposink slot-index=" + std::to_string(index);
}
Harness make_source(int index, const char* caps = kByte) {
  Harness h = make_harness("tensor_reposrc slot-index=" + std::to_string(index) + " caps=\"" +
                           std::string(caps) + "\"");
  gst_harness_play(h.get());
  return h;
}
auto pushing(const Harness& h, const Bytes& bytes) {
  return std::async(std::launch::async,
                    [&h, bytes] { return gst_harness_push(h.get(), frame(bytes)); });
}
Bytes pulled(const Harness& h) {
  const auto buffer = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  return buffer ? content(buffer.get()) : Bytes{};
}

bool ends(const Harness& h) {
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_pull_event(h.get())))
    if (GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS) return true;
  return false;
}

TEST(TensorReposink, StartsWithTheDocumentedValues) {
  const auto sink = lone_element("tensor_reposink");
  guint rate = 1, index = 1;
  gboolean silent = FALSE, sync = TRUE, async = TRUE, qos = FALSE;
  g_object_get(sink.get(), "signal-rate", &rate, "slot-index", &index, "silent", &silent, "sync",
               &sync, "async", &async, "qos", &qos, nullptr);
  EXPECT_EQ(rate, 0u);
  EXPECT_EQ(index, 0u);
  EXPECT_TRUE(silent);
  EXPECT_FALSE(sync);
  EXPECT_FALSE(async);
  EXPECT_TRUE(qos);
  const auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(sink.get()), "signal-rate");
  EXPECT_EQ(G_PARAM_SPEC_UINT(spec)->maximum, 500u);
}

TEST(TensorReposink, SharesTheFrameWithItsMetadata) {
  const Harness sink = make_harness(slot(0), kByte);
  GstBuffer* in = frame(Bytes{1, 2}, 5 * GST_SECOND, GST_SECOND);
  const GstMemory* memory = gst_buffer_peek_memory(in, 0);
  EXPECT_EQ(gst_harness_push(sink.get(), in), GST_FLOW_OK);
  const Harness source = make_source(0);
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(source.get()));
  EXPECT_EQ(gst_buffer_peek_memory(out.get(), 0), memory);
  EXPECT_EQ(content(out.get()), (Bytes{1, 2}));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 5 * GST_SECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), GST_SECOND);
  EXPECT_EQ(stat(sink, "tensor_reposink", "bytes-copied"), 0u);
  EXPECT_EQ(stat(source, "tensor_reposrc", "bytes-copied"), 0u);
}

TEST(TensorReposink, HoldsOneFrameUntilItIsReadAndThenCountsItConsumed) {
  const Harness sink = make_harness(slot(0), kByte);
  EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes{1, 1})), GST_FLOW_OK);
  EXPECT_EQ(stat(sink, "tensor_reposink", "received"), 1u);
  EXPECT_EQ(stat(sink, "tensor_reposink", "held"), 1u);
  auto second = pushing(sink, {2, 2});
  const Harness source = make_source(0);
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  EXPECT_EQ(pulled(source), (Bytes{1, 1}));
  EXPECT_EQ(second.get(), GST_FLOW_OK);
  EXPECT_EQ(pulled(source), (Bytes{2, 2}));
  EXPECT_EQ(stat(sink, "tensor_reposink", "consumed"), 2u);
  EXPECT_EQ(stat(sink, "tensor_reposink", "held"), 0u);
}

// A wrong slot-index: the source reads from another slot.
TEST(TensorReposink, WarnsThatNoSourceReadsItsFrames) {
  const Harness sink = make_harness(slot(4), kByte);
  Errors errors(sink);
  gst_harness_push(sink.get(), frame(Bytes{1, 1}));
  auto second = pushing(sink, {2, 2});
  std::string warning;
  EXPECT_TRUE(
      becomes_true([&] { return !(warning = errors.next_warning()).empty(); }, "a warning"));
  EXPECT_SAYS(warning, "WEIR-5001: a loop has only one end");
  EXPECT_SAYS(warning, "no tensor_reposrc slot-index=4");
  EXPECT_SAYS(warning, "fix: tensor_reposrc slot-index=4");
  const Harness source = make_source(4);
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  EXPECT_EQ(pulled(source), (Bytes{1, 1}));
  EXPECT_EQ(second.get(), GST_FLOW_OK) << "it kept waiting";
}

TEST(TensorReposink, AWaitEndsWithTheElement) {
  const Harness sink = make_harness(slot(0), kByte);
  gst_harness_push(sink.get(), frame(Bytes{1, 1}));
  auto second = pushing(sink, {2, 2});
  gst_element_set_state(sink->element, GST_STATE_READY);
  EXPECT_EQ(second.get(), GST_FLOW_FLUSHING);
  EXPECT_EQ(stat(sink, "tensor_reposink", "held"), 0u) << "the slot was removed with its frame";
  EXPECT_EQ(stat(sink, "tensor_reposink", "dropped-eos"), 1u);
}

TEST(TensorReposink, AWaitSurvivesAPause) {
  const Harness sink = make_harness(slot(0), kByte);
  gst_harness_push(sink.get(), frame(Bytes{1, 1}));
  auto second = pushing(sink, {2, 2});
  wait_for_stat(sink, "tensor_reposink", "received", 2);
  // Each change to PLAYING may meet the wait while it holds GstBaseSink's preroll lock.
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(gst_element_set_state(sink->element, GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
    std::this_thread::yield();
    EXPECT_EQ(gst_element_set_state(sink->element, GST_STATE_PLAYING), GST_STATE_CHANGE_SUCCESS);
  }
  const Harness source = make_source(0);
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  EXPECT_EQ(pulled(source), (Bytes{1, 1}));
  EXPECT_EQ(pulled(source), (Bytes{2, 2}));
  EXPECT_EQ(second.get(), GST_FLOW_OK);
}

TEST(TensorReposink, StoresFramesInPaused) {
  const Harness sink = make_harness(slot(0), kByte);
  for (const GstState first : {GST_STATE_READY, GST_STATE_PLAYING}) {
    gst_element_set_state(sink->element, first);
    EXPECT_EQ(gst_element_set_state(sink->element, GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS)
        << "it does not block preroll";
    gst_harness_set_src_caps_str(sink.get(), kByte);
    EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes{1, 1})), GST_FLOW_OK);
    const Harness source = make_source(0);
    EXPECT_EQ(pulled(source), (Bytes{0, 0}));
    EXPECT_EQ(pulled(source), (Bytes{1, 1}));
  }
}

TEST(TensorReposink, AFlushEndsTheWaitDropsTheFrameAndRestartsTheLoop) {
  const Harness sink = make_harness(slot(0), kByte);
  const Harness source = make_source(0);
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  gst_harness_push_event(sink.get(), gst_event_new_flush_start());
  EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes{3, 3})), GST_FLOW_FLUSHING);
  gst_harness_push_event(sink.get(), gst_event_new_flush_stop(FALSE));
  EXPECT_EQ(pulled(source), (Bytes{0, 0})) << "the frame in transit is lost";
}

TEST(TensorReposink, AFlushCountsDroppedFrames) {
  const Harness sink = make_harness(slot(0), kByte);
  gst_harness_push(sink.get(), frame(Bytes{1, 1}));
  auto second = pushing(sink, {2, 2});
  gst_harness_push_event(sink.get(), gst_event_new_flush_start());
  EXPECT_EQ(second.get(), GST_FLOW_FLUSHING);
  gst_harness_push_event(sink.get(), gst_event_new_flush_stop(FALSE));
  const uint64_t received = stat(sink, "tensor_reposink", "received");
  EXPECT_EQ(stat(sink, "tensor_reposink", "dropped-flush"), received);
  EXPECT_EQ(stat(sink, "tensor_reposink", "held"), 0u);
}

TEST(TensorReposink, EosEndsTheSource) {
  const Harness sink = make_harness(slot(0), kByte);
  const Harness source = make_source(0);
  gst_harness_push(sink.get(), frame(Bytes{1, 1}));
  gst_harness_push_event(sink.get(), gst_event_new_eos());
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  EXPECT_EQ(pulled(source), (Bytes{1, 1}));
  EXPECT_TRUE(ends(source));
}

TEST(TensorReposink, AcceptsEosInPaused) {
  const Harness sink = make_harness(slot(0), kByte);
  const Harness source = make_source(0);
  gst_element_set_state(sink->element, GST_STATE_PAUSED);
  EXPECT_TRUE(gst_harness_push_event(sink.get(), gst_event_new_eos()));
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  EXPECT_TRUE(ends(source));
}

TEST(TensorReposink, DropsAndCountsFramesAfterTheSourceEnded) {
  const Harness sink = make_harness(slot(0), kByte);
  const Harness source =
      make_harness(std::string("tensor_reposrc slot-index=0 num-buffers=1 caps=\"") + kByte + "\"");
  gst_harness_play(source.get());
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  EXPECT_TRUE(ends(source));
  for (uint8_t i = 0; i < 3; ++i)
    EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes{i, i})), GST_FLOW_OK);
  EXPECT_EQ(stat(sink, "tensor_reposink", "dropped-eos"), 3u);
}

TEST(TensorReposink, ANewSlotIndexMovesTheWait) {
  const Harness sink = make_harness(slot(1), kByte);
  const Harness source = make_source(2);
  EXPECT_EQ(pulled(source), (Bytes{0, 0}));
  gst_harness_push(sink.get(), frame(Bytes{1, 1}));
  auto second = pushing(sink, {2, 2});
  g_object_set(find_element(sink, "tensor_reposink").get(), "slot-index", 2u, nullptr);
  EXPECT_EQ(pulled(source), (Bytes{2, 2})) << "the first one was dropped with slot 1";
  EXPECT_EQ(second.get(), GST_FLOW_OK);
  EXPECT_EQ(stat(sink, "tensor_reposink", "dropped-eos"), 1u);
}

TEST(TensorReposink, ReportsAFrameOfTheWrongSize) {
  for (const size_t bytes : {size_t{0}, size_t{1}, size_t{3}}) {
    const Harness sink = make_harness(slot(0), kByte);
    Errors errors(sink);
    EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes(bytes))), GST_FLOW_ERROR);
    const std::string text = errors.next();
    EXPECT_SAYS(text, "WEIR-2004: the size of a buffer does not match its caps");
    EXPECT_SAYS(text, "offered: " + std::to_string(bytes) + " bytes");
    EXPECT_SAYS(text, "needed: 1 tensor: uint8 2 = 2 bytes");
    EXPECT_SAYS(text, "fix: check the upstream element: its caps and its buffers");
    EXPECT_EQ(stat(sink, "tensor_reposink", "dropped-error"), 1u);
  }
}

TEST(TensorReposink, ReportsIncompleteCaps) {
  EXPECT_SAYS(start_error(slot(0), "other/tensor,framerate=30/1"),
              "do not describe the tensors completely");
}

TEST(TensorReposink, RejectsSparseTensors) {
  const Harness sink = make_harness(slot(0), "other/tensors,format=sparse,framerate=30/1");
  EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes{1, 2})), GST_FLOW_NOT_NEGOTIATED);
}

TEST(TensorReposink, ReportsFlexibleFramesWithoutHeaders) {
  const Harness sink = make_harness(slot(0), "other/tensors,format=flexible,framerate=30/1");
  Errors errors(sink);
  EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes{1, 2})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-2005: a memory is too short for a tensor header");
  EXPECT_EQ(stat(sink, "tensor_reposink", "dropped-error"), 1u);
}

}  // namespace tensor_reposink_test
}  // namespace weir::test
