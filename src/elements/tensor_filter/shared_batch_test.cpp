// Filters that share a model by its key collect their frames in common batches, without affecting
// each other.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <fstream>
#include <random>
#include <thread>

#include "elements/tests/closed_pad_test_support.hpp"
#include "elements/tests/element_test_support.hpp"

namespace shared_batch_test {

using namespace weir::test;

constexpr char kCaps[] = "other/tensor,dimension=(string)4:1,type=float32,framerate=30/1";
constexpr char kHour[] = " batch-timeout=3600000000000 ";

// Streams of one model; each model is y = x + 1.
class Streams {
 public:
  Streams(size_t count, const std::string& properties) {
    static std::atomic<int> number{0};
    const std::string path = testing::TempDir() + "weir_fake_model.bin";
    std::ofstream(path) << "x";
    const std::string line = "tensor_filter framework=fake model=" + path +
                             " shared-tensor-filter-key=streams" + std::to_string(++number) + " " +
                             properties;
    for (size_t i = 0; i < count; ++i) harnesses_.push_back(make_harness(line, kCaps));
  }
  const Harness& operator[](size_t stream) const { return harnesses_[stream]; }
  uint64_t count(size_t stream, const char* name) const {
    return stat(harnesses_[stream], "tensor_filter", name);
  }
  static std::vector<float> make_values(size_t stream, int n) {
    const auto s = static_cast<float>(stream), x = static_cast<float>(n);
    return {s, x, s + 0.5f, x + 0.5f};
  }
  GstFlowReturn push(size_t stream, int n) const {
    return gst_harness_push(
        harnesses_[stream].get(),
        frame(make_values(stream, n), static_cast<GstClockTime>(n) * GST_MSECOND, stream));
  }
  void expect_next(size_t stream, int n) const {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(harnesses_[stream].get()));
    ASSERT_TRUE(out) << stream << "/" << n;
    auto expected = make_values(stream, n);
    for (auto& value : expected) value += 1;
    EXPECT_EQ(values<float>(out.get()), expected) << stream << "/" << n;
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), static_cast<GstClockTime>(n) * GST_MSECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), stream) << "of another stream";
  }

 private:
  std::vector<Harness> harnesses_;
};

TEST(SharedBatch, ABatchHasOneFrameOfEachStream) {
  const Streams streams(3, std::string("batch-size=3") + kHour);
  for (int n = 0; n < 5; ++n) {
    for (size_t s = 0; s < 3; ++s) ASSERT_EQ(streams.push(s, n), GST_FLOW_OK);
    for (size_t s = 0; s < 3; ++s) streams.expect_next(s, n);
  }
  for (size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(streams.count(s, "batches"), 5u);
    EXPECT_EQ(streams.count(s, "pushed"), 5u);
    double mean = 0;
    gst_structure_get_double(stats(find_element(streams[s], "tensor_filter").get()).get(),
                             "mean-batch", &mean);
    EXPECT_DOUBLE_EQ(mean, 3.0);
  }
}

// The sum of weights-bytes / shared-by counts each model once.
TEST(SharedBatch, TheBatchSessionIsNotCountedAsAFilter) {
  const Streams streams(2, std::string("batch-size=2") + kHour);
  for (size_t s = 0; s < 2; ++s) streams.push(s, 0);
  for (size_t s = 0; s < 2; ++s) streams.expect_next(s, 0);
  for (size_t s = 0; s < 2; ++s) EXPECT_EQ(streams.count(s, "shared-by"), 2u);
}

TEST(SharedBatch, AStreamThatEndedBlocksNoOther) {
  const Streams streams(2, std::string("batch-size=4") + kHour);
  streams.push(0, 0);
  gst_harness_push_event(streams[0].get(), gst_event_new_eos());
  streams.push(1, 0);
  gst_harness_push_event(streams[1].get(), gst_event_new_eos());
  streams.expect_next(0, 0);
  streams.expect_next(1, 0);
}

TEST(SharedBatch, ADeadStreamCostsNoMoreThanTheTimeout) {
  const Streams streams(2, "batch-size=4 batch-timeout=1000000");
  for (int n = 0; n < 3; ++n) {
    streams.push(1, n);
    streams.expect_next(1, n);
  }
  EXPECT_EQ(streams.count(0, "received"), 0u);
}

TEST(SharedBatch, ABlockedSinkBlocksOnlyItsOwnStream) {
  const Streams streams(2, std::string("batch-size=2") + kHour);
  ClosedPad sink(streams[0]->sinkpad);
  streams.push(0, 0);
  streams.push(1, 0);
  sink.wait_until_one_is_held();
  streams.expect_next(1, 0);
  for (int n = 1; n < 41; ++n) streams.push(1, n);
  for (int n = 1; n < 41; ++n) streams.expect_next(1, n);
  sink.open();
  streams.expect_next(0, 0);
}

TEST(SharedBatch, AFlushDropsOnlyFramesOfItsOwnStream) {
  const Streams streams(2, std::string("batch-size=4") + kHour);
  for (int n = 0; n < 2; ++n) streams.push(0, n);
  streams.push(1, 0);
  gst_harness_push_event(streams[0].get(), gst_event_new_flush_start());
  EXPECT_EQ(streams.count(0, "dropped-flush"), 2u);
  for (int n = 1; n < 4; ++n) streams.push(1, n);
  for (int n = 0; n < 4; ++n) streams.expect_next(1, n);
  EXPECT_EQ(streams.count(1, "dropped-flush"), 0u);
}

TEST(SharedBatch, OtherFiltersContinueWhenOneStops) {
  const Streams streams(3, std::string("batch-size=3") + kHour);
  for (size_t s = 0; s < 2; ++s) streams.push(s, 0);
  gst_element_set_state(find_element(streams[0], "tensor_filter").get(), GST_STATE_READY);
  EXPECT_EQ(streams.count(0, "dropped-flush"), 1u);
  for (int n = 1; n < 3; ++n) streams.push(1, n);
  for (int n = 0; n < 3; ++n) streams.expect_next(1, n);
}

TEST(SharedBatch, FramesOfAnotherShapeAreBatchedSeparately) {
  const Streams streams(2, std::string("batch-size=2") + kHour);
  gst_harness_set_src_caps_str(streams[1].get(),
                               "other/tensor,dimension=(string)4:2,type=float32,framerate=30/1");
  for (int i = 0; i < 2; ++i) {
    streams.push(0, i);
    gst_harness_push(streams[1].get(), frame(std::vector<float>(8, static_cast<float>(i))));
  }
  for (int i = 0; i < 2; ++i) {
    streams.expect_next(0, i);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(streams[1].get()));
    EXPECT_EQ(values<float>(out.get()), std::vector<float>(8, static_cast<float>(i + 1)));
  }
}

TEST(SharedBatch, AnEngineFailureAffectsEveryStreamOfItsBatch) {
  const Streams streams(2, std::string("batch-size=2 custom=fail-at:0") + kHour);
  Errors first(streams[0]), second(streams[1]);
  streams.push(0, 0);
  streams.push(1, 0);
  for (Errors* errors : {&first, &second}) {
    std::string text;
    while (text.empty()) text = errors->next();
    EXPECT_SAYS(text, "ordered to fail");
  }
  for (size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(streams.push(s, 1), GST_FLOW_ERROR);
    EXPECT_EQ(streams.count(s, "dropped-error"), 2u) << "of the batch, and the one after it";
  }
}

// Streams that stall at random: every frame returns once, in order, to its own stream.
TEST(SharedBatch, KeepsAllFramesInOrderUnderStalls) {
  constexpr int kFrames = 120;
  for (uint32_t seed = 0; seed < 4; ++seed) {
    const size_t count = 2 + seed;
    const Streams streams(count, "batch-timeout=300000 batch-size=" + std::to_string(3 + seed % 2));
    std::vector<std::thread> threads;
    for (size_t s = 0; s < count; ++s)
      threads.emplace_back([&, s] {
        std::mt19937 random(seed * 10 + static_cast<uint32_t>(s));
        for (int n = 0; n < kFrames; ++n) {
          EXPECT_EQ(streams.push(s, n), GST_FLOW_OK);
          if (random() % 8 == 0)
            for (uint32_t i = random() % 200; i > 0; --i) std::this_thread::yield();
        }
        gst_harness_push_event(streams[s].get(), gst_event_new_eos());
      });
    for (auto& thread : threads) thread.join();
    for (size_t s = 0; s < count; ++s) {
      for (int n = 0; n < kFrames; ++n) streams.expect_next(s, n);
      EXPECT_EQ(gst_harness_buffers_in_queue(streams[s].get()), 0u);
      EXPECT_EQ(streams.count(s, "received"), streams.count(s, "consumed"));
      EXPECT_EQ(streams.count(s, "held"), 0u);
    }
  }
}

}  // namespace shared_batch_test
