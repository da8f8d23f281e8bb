// tensor_filter batch-size: the results of a batch are the same as those of single frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <fstream>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"

namespace batch_test {

using namespace weir::test;

// Frames of one row of four numbers; the model adds 1.
constexpr char kCaps[] = "other/tensor,dimension=(string)4:1,type=float32,framerate=30/1";
constexpr char kHour[] = " batch-timeout=3600000000000 ";  // no batch reaches its timeout

std::string line(const std::string& properties, const char* engine = "fake") {
  const std::string path = testing::TempDir() + "weir_fake_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=" + std::string(engine) + " model=" + path + " " + properties;
}
std::vector<float> row(int n) {
  const auto x = static_cast<float>(n);
  return {x, x + 0.25f, x + 0.5f, x + 0.75f};
}
GstBuffer* numbered(int n) {
  return frame(row(n), static_cast<GstClockTime>(n) * GST_SECOND, GST_MSECOND);
}
void push(const Harness& h, int from, int to) {
  for (int i = from; i < to; ++i) ASSERT_EQ(gst_harness_push(h.get(), numbered(i)), GST_FLOW_OK);
}
void push_eos(const Harness& h) {
  gst_harness_push_event(h.get(), gst_event_new_eos());
}
void expect_next(const Harness& h, int from, int to) {
  for (int i = from; i < to; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_TRUE(out) << i;
    EXPECT_EQ(values<float>(out.get()), row(i + 1));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), static_cast<GstClockTime>(i) * GST_SECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), GST_MSECOND);
  }
}
uint64_t count(const Harness& h, const char* name) {
  return stat(h, "tensor_filter", name);
}
double number(const Harness& h, const char* name) {
  double value = -1;
  EXPECT_TRUE(
      gst_structure_get_double(stats(find_element(h, "tensor_filter").get()).get(), name, &value))
      << name;
  return value;
}
// Waits until the downstream pad has received EOS.
void wait_for_eos(const Harness& h) {
  for (;;) {
    const auto event = Ref<GstEvent>::adopt(gst_harness_pull_event(h.get()));
    ASSERT_TRUE(event);
    if (GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS) return;
  }
}

TEST(TensorFilterBatch, EachFrameGetsItsOwnResultAndTime) {
  auto h = make_harness(line(std::string("batch-size=4") + kHour), kCaps);
  push(h, 0, 10);
  push_eos(h);
  expect_next(h, 0, 10);
  wait_for_eos(h);
  EXPECT_EQ(count(h, "batches"), 3u);
  EXPECT_EQ(count(h, "invokes"), 3u);
  EXPECT_DOUBLE_EQ(number(h, "mean-batch"), 10.0 / 3);
  EXPECT_DOUBLE_EQ(number(h, "batch-fill"), 10.0 / 12);
  EXPECT_EQ(count(h, "consumed"), 10u);
  EXPECT_EQ(count(h, "held"), 0u);
  EXPECT_EQ(count(h, "bytes-copied"), 10 * 16u) << "copied into the batch, not out of it";
}

TEST(TensorFilterBatch, WithoutABatchSizeNothingIsBatched) {
  auto h = make_harness(line(""), kCaps);
  push(h, 0, 2);
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 2u);
  EXPECT_FALSE(
      gst_structure_has_field(stats(find_element(h, "tensor_filter").get()).get(), "batches"));
}

TEST(TensorFilterBatch, AnIncompleteBatchRunsAtTheTimeout) {
  auto h = make_harness(line("batch-size=64 batch-timeout=1000000"), kCaps);
  push(h, 0, 1);
  expect_next(h, 0, 1);
  push(h, 1, 3);
  expect_next(h, 1, 3);
}

TEST(TensorFilterBatch, FramesOfSeveralRowsAreBatched) {
  auto h = make_harness(line(std::string("batch-size=3") + kHour),
                        "other/tensor,dimension=(string)4:2,type=float32,framerate=30/1");
  for (int i = 0; i < 3; ++i)
    gst_harness_push(h.get(), frame(std::vector<float>(8, static_cast<float>(i))));
  for (int i = 0; i < 3; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(values<float>(out.get()), std::vector<float>(8, static_cast<float>(i + 1)));
  }
}

TEST(TensorFilterBatch, AModelWithAFixedBatchAcceptsSingleFrames) {
  auto h = make_harness(line(std::string("batch-size=4 custom=rows:4") + kHour), kCaps);
  push(h, 0, 6);
  push_eos(h);
  expect_next(h, 0, 6);
  wait_for_eos(h);
  EXPECT_EQ(count(h, "batches"), 2u);
  EXPECT_EQ(count(h, "pushed"), 6u) << "frames beyond the second batch are dropped";
  EXPECT_SAYS(start_error(line("batch-size=4 custom=rows:4"),
                          "other/tensor,dimension=(string)4:4,type=float32,framerate=30/1"),
              "dimension 1 is 4, needed is 1");
}

TEST(TensorFilterBatch, TheModelGetsMemoryAsItRequests) {
  auto h =
      make_harness(line("batch-size=2 custom=alignment:4096,padding:100 batch-timeout=0"), kCaps);
  push(h, 0, 5);
  push_eos(h);
  expect_next(h, 0, 5);
}

TEST(TensorFilterBatch, InputsAreCombinedWithOutputsOfTheSameFrame) {
  auto h = make_harness(line(std::string("batch-size=2 output-combination=i0,o0") + kHour), kCaps);
  push(h, 5, 7);
  for (int i = 5; i < 7; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(gst_buffer_n_memory(out.get()), 2u);
    auto expected = row(i);
    const auto result = row(i + 1);
    expected.insert(expected.end(), result.begin(), result.end());
    EXPECT_EQ(values<float>(out.get()), expected);
  }
  EXPECT_EQ(count(h, "bytes-copied"), 2 * 16u);
}

TEST(TensorFilterBatch, ResultsGetHeadersWhereThePeerNeedsThem) {
  auto h = make_harness(line(std::string("batch-size=2") + kHour) +
                            " ! capsfilter caps=other/tensors,format=flexible",
                        kCaps);
  push(h, 0, 2);
  for (int i = 0; i < 2; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(gst_buffer_get_size(out.get()), 128u + 16);
    const auto all = values<float>(out.get());
    EXPECT_EQ(std::vector<float>(all.begin() + 32, all.end()), row(i + 1));
  }
}

// A frame of a flexible stream: its header gives the number of rows of four.
GstBuffer* with_header(const std::vector<float>& numbers) {
  weir::TensorHeader header;
  header.spec.type = weir::ElementType::Float32;
  header.spec.shape = {4, static_cast<uint32_t>(numbers.size() / 4)};
  GstBuffer* out =
      gst_buffer_new_allocate(nullptr, weir::kTensorHeaderBytes + numbers.size() * 4, nullptr);
  std::array<std::byte, weir::kTensorHeaderBytes> bytes{};
  weir::write_tensor_header(header, bytes);
  gst_buffer_fill(out, 0, bytes.data(), bytes.size());
  gst_buffer_fill(out, bytes.size(), numbers.data(), numbers.size() * 4);
  return out;
}

TEST(TensorFilterBatch, BatchesAFlexibleStreamForAModelOfOneShape) {
  constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=30/1";
  for (const char* one_shape : {"custom=rows:2", "input=4:1 inputtype=float32"}) {
    auto h = make_harness(line(std::string("batch-size=2 ") + one_shape + kHour), kFlexible);
    Errors errors(h);
    for (int i = 0; i < 4; ++i)
      ASSERT_EQ(gst_harness_push(h.get(), with_header(row(i))), GST_FLOW_OK);
    for (int i = 0; i < 4; ++i)
      EXPECT_EQ(values<float>(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())).get()), row(i + 1))
          << one_shape;
    EXPECT_EQ(count(h, "batches"), 2u);
    EXPECT_EQ(gst_harness_push(h.get(), with_header(std::vector<float>(8, 1))), GST_FLOW_ERROR);
    EXPECT_EQ(count(h, "dropped-error"), 1u);
    EXPECT_SAYS(errors.next(), "4:2") << "the shape of the stream";
  }
}

TEST(TensorFilterBatch, FailsTheStreamWhenTheEngineFails) {
  auto h = make_harness(line(std::string("batch-size=2 custom=fail-at:1") + kHour), kCaps);
  Errors errors(h);
  push(h, 0, 2);
  expect_next(h, 0, 2);
  gst_harness_push(h.get(), numbered(2));
  gst_harness_push(h.get(), numbered(3));
  wait_for_stat(h, "tensor_filter", "dropped-error", 2);
  EXPECT_SAYS(errors.next(), "ordered to fail");
  EXPECT_EQ(errors.next(), "") << "one error for the batch";
  EXPECT_EQ(gst_harness_push(h.get(), numbered(4)), GST_FLOW_ERROR);
  EXPECT_EQ(count(h, "held"), 0u);
}

TEST(TensorFilterBatch, AnErrorIsPostedAndCountedBeforeEos) {
  auto h = make_harness(line(std::string("batch-size=4 custom=fail-at:0") + kHour), kCaps);
  Errors errors(h);
  push(h, 0, 3);
  push_eos(h);
  wait_for_eos(h);
  EXPECT_SAYS(errors.next(), "ordered to fail");
  EXPECT_EQ(count(h, "dropped-error"), 3u);
  EXPECT_EQ(count(h, "held"), 0u);
}

TEST(TensorFilterBatch, ABatchThatTheEngineDropsIsCounted) {
  auto h = make_harness(line(std::string("batch-size=2 custom=drop-at:1") + kHour), kCaps);
  push(h, 0, 6);
  expect_next(h, 0, 2);
  expect_next(h, 4, 6);
  push_eos(h);
  wait_for_eos(h);
  EXPECT_EQ(count(h, "dropped-policy"), 2u);
  EXPECT_EQ(count(h, "held"), 0u);
}

TEST(TensorFilterBatch, ABufferOfTheWrongSizeDoesNotAffectEarlierOnes) {
  auto h = make_harness(line(std::string("batch-size=4") + kHour), kCaps);
  Errors errors(h);
  push(h, 0, 3);
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-2004");
  push_eos(h);
  expect_next(h, 0, 3);
  EXPECT_EQ(count(h, "dropped-error"), 1u);
}

TEST(TensorFilterBatch, AFlushDropsWaitingFramesAndTheStreamContinues) {
  auto h = make_harness(line(std::string("batch-size=4") + kHour), kCaps);
  push(h, 0, 2);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  EXPECT_EQ(count(h, "dropped-flush"), 2u);
  EXPECT_EQ(gst_harness_push(h.get(), numbered(2)), GST_FLOW_FLUSHING);
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  push(h, 3, 7);
  expect_next(h, 3, 7);
  EXPECT_EQ(count(h, "received"), count(h, "consumed") + count(h, "dropped-flush"));
}

TEST(TensorFilterBatch, StopsWithWaitingFrames) {
  auto h = make_harness(line(std::string("batch-size=4") + kHour), kCaps);
  push(h, 0, 3);
  const auto filter = find_element(h, "tensor_filter");
  gst_element_set_state(filter.get(), GST_STATE_READY);
  EXPECT_EQ(stat(filter.get(), "dropped-flush"), 3u);
  EXPECT_EQ(stat(filter.get(), "held"), 0u);
}

TEST(TensorFilterBatch, NewCapsFollowTheFramesBeforeThem) {
  auto h = make_harness(line(std::string("batch-size=4") + kHour), kCaps);
  push(h, 0, 3);
  gst_harness_set_src_caps_str(h.get(),
                               "other/tensor,dimension=(string)4:2,type=float32,framerate=30/1");
  expect_next(h, 0, 3);
  for (int i = 0; i < 4; ++i) gst_harness_push(h.get(), frame(std::vector<float>(8, 5)));
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(values<float>(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())).get()),
              std::vector<float>(8, 6));
  EXPECT_EQ(count(h, "batches"), 2u);
}

TEST(TensorFilterBatch, EventsKeepTheirPlaceBetweenFrames) {
  auto h = make_harness(line(std::string("batch-size=2") + kHour), kCaps);
  std::vector<std::string> order;  // written by the filter's thread, read after EOS
  const auto note = [](GstPad*, GstPadProbeInfo* info, gpointer data) {
    auto* list = static_cast<std::vector<std::string>*>(data);
    if (info->type & GST_PAD_PROBE_TYPE_BUFFER)
      list->emplace_back("frame");
    else if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_CUSTOM_DOWNSTREAM)
      list->emplace_back("mark");
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(
      h->sinkpad, GstPadProbeType(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM),
      note, &order, nullptr);
  push(h, 0, 1);
  gst_harness_push_event(
      h.get(), gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty("mark")));
  push(h, 1, 3);
  push_eos(h);
  wait_for_eos(h);
  EXPECT_EQ(order, (std::vector<std::string>{"frame", "mark", "frame", "frame"}));
}

TEST(TensorFilterBatch, TheTimeoutIsPartOfTheLiveLatency) {
  auto h = make_harness(line("batch-size=2 batch-timeout=7000000"), kCaps);
  gst_harness_set_upstream_latency(h.get(), 3 * GST_MSECOND);
  EXPECT_EQ(gst_harness_query_latency(h.get()), 10 * GST_MSECOND);
  auto alone = make_harness(line("batch-timeout=7000000"), kCaps);
  gst_harness_set_upstream_latency(alone.get(), 3 * GST_MSECOND);
  EXPECT_EQ(gst_harness_query_latency(alone.get()), 3 * GST_MSECOND) << "nothing is collected";
}

// No batch reaches its timeout, and there are never four frames.
TEST(TensorFilterBatch, ABatchRunsWhenMaxBytesIsReached) {
  auto h = make_harness(line(std::string("batch-size=4 max-bytes=32") + kHour), kCaps);
  push(h, 0, 6);
  push_eos(h);
  wait_for_eos(h);
  expect_next(h, 0, 6);
  EXPECT_GE(stat(h, "tensor_filter", "batches"), 3u) << "at most two frames";
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-most"), 32u);
}

// If the previous batch has already ended, there is room; so this is tried several times.
TEST(TensorFilterBatch, AFrameBeyondMaxBytesIsDropped) {
  for (const char* when_busy : {"drop-new", "drop-old"}) {
    uint64_t dropped = 0;
    for (int tries = 0; tries < 200 && dropped == 0; ++tries) {
      auto h = make_harness(
          line(std::string("batch-size=4 max-bytes=32") + kHour + "when-busy=" + when_busy), kCaps);
      push(h, 0, 3);
      expect_next(h, 0, 2);
      dropped = count(h, "dropped-policy");
    }
    EXPECT_EQ(dropped, 1u) << when_busy;
  }
}

TEST(TensorFilterBatch, ReportsWhyAModelCannotBeBatched) {
  const std::string state = start_error(line("batch-size=2 custom=stateful:1"));
  EXPECT_SAYS(state, "WEIR-3013: the model keeps state from frame to frame");
  EXPECT_SAYS(state, "fix: set batch-size=1 and give each stream its own tensor_filter");
  const std::string other = start_error(line("batch-size=3 custom=rows:4"));
  EXPECT_SAYS(other, "WEIR-3013: the model cannot run 3 frames at once");
  EXPECT_SAYS(other, "first difference: input 0 (x): dimension 1 is 4");
  EXPECT_SAYS(other, "fix: batch-size=4");
  EXPECT_SAYS(start_error(line("batch-size=2 custom=rows:1")),
              "fix: export the model with a dynamic first axis, or set batch-size=1");
  const std::string workers = start_error(line("batch-size=2 workers=3"));
  EXPECT_SAYS(workers, "WEIR-1004: batches run one at a time");
  EXPECT_SAYS(workers, "in one session\n  offered: workers=3 with batch-size=2");
  EXPECT_SAYS(workers, "needed: workers=1, and more threads of the engine for each batch; or");
  EXPECT_SAYS(workers, "fix: tensor_filter batch-size=2 workers=1 threads=");
  EXPECT_SAYS(start_error(line("batch-size=2", "scaling")),
              "input 0 (values): its only dimension belongs to one frame");
  const std::string flexible =
      start_error(line("batch-size=2"), "other/tensors,format=flexible,framerate=30/1");
  EXPECT_SAYS(flexible, "WEIR-3013: frames whose shapes may change");
  EXPECT_SAYS(flexible, "fix: tensor_filter input=... inputtype=..., tensor_converter");
}

}  // namespace batch_test
