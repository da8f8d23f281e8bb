// tensor_aggregator in a harness: the frames of each window against a simple reference.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <random>

#include "elements/tests/element_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace tensor_aggregator_test {

using namespace weir::test;

constexpr char kName[] = "tensor_aggregator";

Harness aggregator(const std::string& properties, const std::string& caps) {
  return make_harness("tensor_aggregator " + properties, caps);
}
uint64_t count(const Harness& h, const char* name) {
  return stat(h, kName, name);
}
Bytes random_bytes(size_t size, std::mt19937* random) {
  Bytes out(size);
  for (auto& b : out) b = static_cast<uint8_t>((*random)());
  return out;
}
Bytes slice(const Bytes& all, size_t begin, size_t size) {
  return {all.begin() + static_cast<std::ptrdiff_t>(begin),
          all.begin() + static_cast<std::ptrdiff_t>(begin + size)};
}
void expect_ledger(const Harness& h) {
  EXPECT_EQ(count(h, "received"), count(h, "consumed") + count(h, "dropped") + count(h, "held"));
}

TEST(TensorAggregator, CombinesFourFrames) {
  auto h = aggregator("frames-in=1 frames-out=4 frames-flush=4 frames-dim=3",
                      tensors("uint8", "3:2:2:1"));
  const Bytes all = ramp(12 * 8);
  for (size_t i = 0; i < 8; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame(slice(all, 12 * i, 12))), GST_FLOW_OK);
  for (size_t i = 0; i < 2; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), slice(all, 48 * i, 48));
  }
  EXPECT_EQ(caps_text(h),
            "other/tensors, format=(string)static, num_tensors=(int)1, "
            "dimensions=(string)3:2:2:4, types=(string)uint8, framerate=(fraction)30/1");
  EXPECT_EQ(count(h, "pushed"), 2u);
  EXPECT_EQ(count(h, "consumed"), 8u);
  EXPECT_EQ(count(h, "bytes-copied"), 96u) << "each byte once";
}

// Window k holds the frames [k * step, k * step + out), whichever buffers they arrived in.
TEST(TensorAggregator, HoldsTheFramesOfEveryCombination) {
  std::mt19937 random(1);
  for (size_t in = 1; in <= 5; ++in)
    for (size_t out = 1; out <= 6; ++out)
      for (size_t flush = 0; flush <= in * ((out + in - 1) / in); ++flush) {
        constexpr size_t kBytes = 3, kBuffers = 11;
        auto h = aggregator("frames-dim=1 frames-in=" + std::to_string(in) + " frames-out=" +
                                std::to_string(out) + " frames-flush=" + std::to_string(flush),
                            tensors("uint8", "3:" + std::to_string(in)));
        const Bytes all = random_bytes(kBytes * in * kBuffers, &random);
        for (size_t i = 0; i < kBuffers; ++i)
          ASSERT_EQ(gst_harness_push(h.get(), frame(slice(all, kBytes * in * i, kBytes * in))),
                    GST_FLOW_OK);
        const size_t step = flush ? flush : out, frames = in * kBuffers;
        std::vector<bool> in_a_window(frames);
        for (size_t begin = 0; begin + out <= frames; begin += step) {
          auto window = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
          ASSERT_TRUE(window) << in << " " << out << " " << flush << " " << begin;
          std::fill_n(in_a_window.begin() + static_cast<long>(begin), out, true);
          ASSERT_EQ(content(window.get()), slice(all, kBytes * begin, kBytes * out))
              << in << " " << out << " " << flush << " " << begin;
        }
        EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 0u);
        expect_ledger(h);
        gst_harness_push_event(h.get(), gst_event_new_eos());
        EXPECT_EQ(count(h, "held"), 0u);
        expect_ledger(h);
        const auto unused = std::count(in_a_window.begin(), in_a_window.end(), false);
        EXPECT_EQ(count(h, "frames-lost"), static_cast<uint64_t>(unused))
            << in << " " << out << " " << flush;
      }
}

// 1 to 20 tensors along dimension 1: dimension 2 makes the frames interleave.
TEST(TensorAggregator, InterleavesEachOfOneToTwentyTensors) {
  std::mt19937 random(2);
  for (const std::string flush : {"3", "1"})
    for (size_t tensors_in = 1; tensors_in <= 20; ++tensors_in) {
      std::string types, dims, big;
      std::vector<size_t> rows;  // of 2 bytes, `outer` times
      const size_t outer = 2;
      for (size_t i = 0; i < tensors_in; ++i) {
        rows.push_back(1 + i % 3);
        types += i ? ",uint8" : "uint8";
        dims += (i ? "," : "") + ("2:" + std::to_string(rows[i]) + ":2");
        big += (i ? "," : "") + ("2:" + std::to_string(3 * rows[i]) + ":2");
      }
      auto h = aggregator("frames-dim=1 frames-out=3 frames-flush=" + flush, tensors(types, dims));
      std::vector<Bytes> frames;
      Bytes expected;
      size_t frame_bytes = 0;
      for (const size_t r : rows) frame_bytes += 2 * r * outer;
      for (int f = 0; f < 3; ++f) frames.push_back(random_bytes(frame_bytes, &random));
      size_t begin = 0;
      for (const size_t r : rows) {
        for (size_t o = 0; o < outer; ++o)
          for (const Bytes& f : frames) {
            const Bytes block = slice(f, begin + o * 2 * r, 2 * r);
            expected.insert(expected.end(), block.begin(), block.end());
          }
        begin += 2 * r * outer;
      }
      for (const Bytes& f : frames) ASSERT_EQ(gst_harness_push(h.get(), frame(f)), GST_FLOW_OK);
      auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_EQ(gst_buffer_n_memory(out.get()), std::min<size_t>(tensors_in, 16));
      size_t header_at = 0;
      for (guint i = 0; i < std::min<size_t>(tensors_in, 15); ++i)
        header_at += gst_memory_get_sizes(gst_buffer_peek_memory(out.get(), i), nullptr, nullptr);
      Bytes got = content(out.get());
      const auto header = got.begin() + static_cast<std::ptrdiff_t>(header_at);
      if (tensors_in > 16) got.erase(header, header + 19224);
      EXPECT_EQ(got, expected) << tensors_in << " flush " << flush;
      auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
      EXPECT_EQ(gst_structure_get_string(gst_caps_get_structure(caps.get(), 0), "dimensions"), big);
    }
}

TEST(TensorAggregator, AppendsWholeFramesWithoutConcat) {
  auto h = aggregator("frames-dim=0 frames-out=2 concat=false", tensors("uint8", "2:2"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2, 3, 4})), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{5, 6, 7, 8})), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)4:2,");
}

TEST(TensorAggregator, PassesBuffersThatAreCompleteWindows) {
  auto h = aggregator("frames-in=2 frames-out=2 frames-dim=0", tensors("uint8", "4"));
  GstBuffer* in = frame(ramp(4), 7, 8);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(out.get(), in);
  EXPECT_EQ(count(h, "bytes-copied"), 0u);
}

TEST(TensorAggregator, SplitsWithoutCopying) {
  auto h = aggregator("frames-in=6 frames-out=2 frames-dim=0", tensors("uint8,uint8", "6,12"));
  GstBuffer* in = gst_buffer_new();
  for (const size_t size : {6, 12}) {
    auto part = Ref<GstBuffer>::adopt(frame(ramp(size)));
    gst_buffer_append_memory(in, gst_buffer_get_memory(part.get(), 0));
  }
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  for (uint8_t i = 0; i < 3; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(gst_buffer_n_memory(out.get()), 2u);
    const auto a = static_cast<uint8_t>(2 * i), b = static_cast<uint8_t>(4 * i);
    EXPECT_EQ(content(out.get()),
              (Bytes{a, static_cast<uint8_t>(a + 1), b, static_cast<uint8_t>(b + 1),
                     static_cast<uint8_t>(b + 2), static_cast<uint8_t>(b + 3)}));
  }
  EXPECT_EQ(count(h, "bytes-copied"), 0u);
  EXPECT_EQ(count(h, "consumed"), 1u);
}

TEST(TensorAggregator, CopiesPartsOfMemoryThatCannotBeShared) {
  auto h = aggregator("frames-in=3 frames-out=1 frames-dim=0", tensors("uint8", "6"));
  GstBuffer* in = frame(ramp(6));
  GST_MINI_OBJECT_FLAG_SET(gst_buffer_peek_memory(in, 0), GST_MEMORY_FLAG_NO_SHARE);
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  for (const uint8_t first : {0, 2, 4}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), (Bytes{first, static_cast<uint8_t>(first + 1)}));
  }
  EXPECT_EQ(count(h, "bytes-copied"), 6u);
}

TEST(TensorAggregator, KeepsClientsSeparate) {
  auto h = aggregator("frames-out=2 frames-dim=0", tensors("uint8", "1"));
  const auto push = [&h](uint8_t value, gint64 client) {
    GstBuffer* b = frame(Bytes{value});
    ASSERT_TRUE(weir::gst::set_client(b, client));
    ASSERT_EQ(gst_harness_push(h.get(), b), GST_FLOW_OK);
  };
  push(1, 10), push(2, 20), push(3, 10), push(4, 20);
  for (const auto& [bytes, client] : {std::pair{Bytes{1, 3}, 10}, std::pair{Bytes{2, 4}, 20}}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), bytes);
    EXPECT_EQ(weir::gst::get_client_id(out.get()), client);
  }
}

// Only a dimension other than the picture's keeps the pixels in place, and the source map.
TEST(TensorAggregator, KeepsASourceMapThatAllFramesShare) {
  for (const auto& [dimension, maps] : {std::pair{"3", 1u}, std::pair{"2", 0u}}) {
    auto h = make_harness(
        std::string("tensor_converter ! tensor_aggregator frames-out=2 frames-dim=") + dimension,
        video("GRAY8", 4, 3));
    for (int i = 0; i < 2; ++i) ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(12))), GST_FLOW_OK);
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(weir::gst::source_maps(out.get()).size(), maps) << "along " << dimension;
  }
}

TEST(TensorAggregator, CountsFramesLostAtEos) {
  auto h = aggregator("frames-in=2 frames-out=4 frames-dim=0", tensors("uint8", "2"));
  for (int i = 0; i < 5; ++i) ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(2))), GST_FLOW_OK);
  EXPECT_EQ(count(h, "held"), 1u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(count(h, "dropped-eos"), 1u);
  EXPECT_EQ(count(h, "frames-lost"), 2u);
  EXPECT_EQ(count(h, "held"), 0u);
}

TEST(TensorAggregator, StartsAgainAfterAFlush) {
  auto h = aggregator("frames-out=2 frames-dim=0", tensors("uint8", "1"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_OK);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(count(h, "dropped-flush"), 1u);
  for (const uint8_t value : {2, 3})
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{value})), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{2, 3}));
}

TEST(TensorAggregator, StartsAgainOnlyWhenTheTensorsChange) {
  auto h = aggregator("frames-out=2 frames-dim=0", tensors("uint8", "1"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_OK);
  gst_harness_set_src_caps_str(h.get(), (tensors("uint8", "1:1")).c_str());
  EXPECT_EQ(count(h, "held"), 1u) << "1 and 1:1 are the same tensor";
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2").c_str());
  EXPECT_EQ(count(h, "dropped-flush"), 1u);
  for (int i = 0; i < 2; ++i) ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{5, 6})), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{5, 6, 5, 6}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)4,");
}

TEST(TensorAggregator, ReportsInvalidFramesFlush) {
  const std::string error =
      start_error("tensor_aggregator frames-in=2 frames-out=3 frames-flush=9 frames-dim=0");
  EXPECT_SAYS(error, "WEIR-1004: frames-flush exceeds the number of frames");
  EXPECT_SAYS(error, "offered: frames-flush=9, with frames-in=2 and frames-out=3");
  EXPECT_SAYS(error, "fix: frames-flush=4");
}

TEST(TensorAggregator, ReportsADimensionThatIsNotAMultiple) {
  const std::string error =
      start_error("tensor_aggregator frames-in=4 frames-dim=1", tensors("uint8", "3:10"));
  EXPECT_SAYS(error, "offered: frames-in=4, and dimension 1 of tensor 0 (uint8 3:10) is 10");
  EXPECT_SAYS(error, "fix: frames-in=2");
}

TEST(TensorAggregator, RejectsFramesOfTheWrongSize) {
  for (const char* properties : {"frames-out=2 frames-dim=0", "frames-dim=0"})
    for (const size_t bytes : {size_t{3}, size_t{5}}) {
      auto h = aggregator(properties, tensors("uint8", "4"));
      Errors errors(h);
      EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(bytes))), GST_FLOW_ERROR);
      const std::string error = errors.next();
      EXPECT_SAYS(error, "WEIR-2004: the size of a buffer does not match its caps");
      EXPECT_SAYS(error, std::to_string(bytes) + " bytes");
      EXPECT_EQ(count(h, "dropped-error"), 1u);
      EXPECT_EQ(count(h, "held"), 0u);
    }
}

TEST(TensorAggregator, ReportsCapsThatDownstreamRejects) {
  auto h = aggregator("frames-out=2 frames-dim=0", "");
  Errors errors(h);
  gst_harness_set_sink_caps_str(h.get(), tensors("uint8", "3").c_str());
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2").c_str());
  const std::string error = errors.next();
  EXPECT_SAYS(error,
              "WEIR-2001: the element downstream of tensor_aggregator does not accept its output");
  EXPECT_SAYS(error, "offered: 1 tensor: uint8 4\n");
  EXPECT_SAYS(error, "first difference: tensor 0: dimension is 4, needed is 3");
}

// docs/compatibility/routing.md 6.6: caps stay unchanged when the dimension is beyond the rank; a
// warning is posted.
TEST(TensorAggregator, WarnsWhenCapsDoNotDescribeTheFrames) {
  auto h = aggregator("frames-out=2", "");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "3:4").c_str());
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "frames-dim is beyond the dimensions of the tensors");
  EXPECT_SAYS(warning, "fix: tensor_aggregator frames-dim=1");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:4,");
  for (int i = 0; i < 2; ++i) ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(12))), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(gst_buffer_get_size(out.get()), 24u);
}

TEST(TensorAggregator, SuggestsADimensionThatHoldsWholeFrames) {
  const auto fix = [](const char* dimensions) {
    auto h = aggregator("frames-in=2 frames-out=4", "");
    Errors errors(h);
    gst_harness_set_src_caps_str(h.get(), tensors("uint8", dimensions).c_str());
    const std::string warning = errors.next_warning();
    EXPECT_SAYS(warning, "frames-dim is beyond");
    return warning;
  };
  EXPECT_SAYS(fix("3:4:1"), "fix: tensor_aggregator frames-dim=1");
  EXPECT_EQ(fix("3:5:4:1").find("frames-dim=3"), std::string::npos);
  EXPECT_EQ(fix("3:4:3").find("fix: tensor_aggregator frames-dim=2"), std::string::npos);
}

// The queue of the other branch is full before the first window is whole, and the pipeline cannot
// preroll.
TEST(TensorAggregator, WarnsOfAQueueThatIsShorterThanTheWindow) {
  const auto line = [](const std::string& queue, int frames, const std::string& sink = "fakesink") {
    return "videotestsrc num-buffers=300 ! "
           "video/x-raw,format=GRAY8,width=2,height=2,framerate=100/1 ! tensor_converter ! tee "
           "name=t t. ! queue name=short " +
           queue +
           " ! fakesink t. ! queue ! tensor_aggregator name=windows frames-dim=3 frames-out=" +
           std::to_string(frames) + " ! " + sink;
  };
  const std::string warning = weir::test::PlayedPipeline(line("", 128)).first_warning();
  EXPECT_SAYS(warning,
              "WEIR-5001: the pipeline may stall at its start: a window is longer than a queue in "
              "another branch of its tee");
  EXPECT_SAYS(warning,
              "offered: short beside windows, which collects 127 buffers of 1270 ms and 508 bytes");
  const std::string fixed = "max-size-buffers=0 max-size-bytes=0 max-size-time=2540000000";
  EXPECT_SAYS(warning, "fix: queue name=short " + fixed);
  EXPECT_EQ(weir::test::PlayedPipeline(line(fixed, 128)).first_warning(), "");
  EXPECT_EQ(weir::test::PlayedPipeline(line("", 64)).first_warning(), "");
  const std::string at_once = "fakesink async=false";
  EXPECT_EQ(weir::test::PlayedPipeline(line("", 128, at_once)).first_warning(), "")
      << "the pipeline starts before the first window";
  const std::string two = "tee name=u  u. ! queue ! " + at_once + "  u. ! queue ! fakesink";
  EXPECT_SAYS(weir::test::PlayedPipeline(line("", 128, two)).first_warning(), "WEIR-5001");
}

// A queue holds 10 MiB by default: four pictures, and the sink another one.
TEST(TensorAggregator, WarnsOfAQueueThatHoldsFewerBytesThanTheWindow) {
  const auto line = [](int frames) {
    return "videotestsrc num-buffers=12 ! "
           "video/x-raw,format=RGB,width=1280,height=720,framerate=30/1 ! tensor_converter ! tee "
           "name=t t. ! queue name=short ! fakesink t. ! queue ! tensor_aggregator name=windows "
           "frames-dim=3 frames-out=" +
           std::to_string(frames) + " ! fakesink";
  };
  EXPECT_SAYS(weir::test::PlayedPipeline(line(6)).first_warning(),
              "offered: short beside windows, which collects 5 buffers of 166 ms and 13824000 "
              "bytes");
  const weir::test::PlayedPipeline holds(line(5));
  EXPECT_EQ(holds.first_warning(), "");
  EXPECT_EQ(holds.stat("windows", "pushed"), 2u);
}

}  // namespace tensor_aggregator_test
