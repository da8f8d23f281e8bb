// tensor_converter with an external converter: tests/support/numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_converter/converter_test_support.hpp"

namespace converted_test {

using namespace weir;
using namespace weir::testing_tensor_converter;

constexpr char kNumbers[] = "application/x-numbers,framerate=10/1";

GstBuffer* text(const std::string& words) {
  return frame(Bytes(words.begin(), words.end()));
}
std::vector<int32_t> values(GstBuffer* b) {
  const Bytes bytes = content(b);
  std::vector<int32_t> out(bytes.size() / 4);
  std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}
std::vector<int32_t> converted(const Harness& h, const std::string& words) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), text(words)));
  return values(out.get());
}

TEST(ConverterModule, IsFoundByItsCapsAndJoinsTheTemplate) {
  auto h = harness("", kNumbers);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1:1:1:1, types=(string)uint8");
  EXPECT_EQ(converted(h, "1 2 3"), (std::vector{1, 2, 3}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3, types=(string)int32");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
  EXPECT_SAYS(accepted(h, "ANY"), "application/x-numbers");
  auto element = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_converter"));
  gchar* names = nullptr;
  g_object_get(element.get(), "sub-plugins", &names, nullptr);
  const weir::gst::UniqueText owned{names};
  EXPECT_SAYS(std::string(names), "numbers");
}

TEST(ConverterModule, MayMakeOtherTensorsOfEachFrame) {
  auto h = harness("", kNumbers);
  EXPECT_EQ(converted(h, "7"), std::vector{7});
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), text("1 2;3")));
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(values(out.get()), (std::vector{1, 2, 3}));
  EXPECT_SAYS(caps_text(h), "num_tensors=(int)2, dimensions=(string)\"2\\,1\"");
}

TEST(ConverterModule, MaySayItsTensorsBeforeTheFirstFrame) {
  auto h = harness("", std::string(kNumbers) + ",shape=three");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:1, types=(string)int32");
  auto open = harness("", std::string(kNumbers) + ",shape=unknown");
  EXPECT_SAYS(caps_text(open), "dimensions=(string)1:1:1:1, types=(string)uint8");
  Harness peer{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(
      peer.get(), "other/tensor,dimension=(string)5,type=(string)int32,framerate=10/1");
  gst_harness_set_src_caps_str(peer.get(), kNumbers);
  EXPECT_SAYS(caps_text(peer), "dimension=(string)5, type=(string)int32");
}

TEST(ConverterModule, MustMatchInputDimAndInputType) {
  auto h = harness("input-dim=2 input-type=int32", kNumbers);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2, types=(string)int32");
  EXPECT_EQ(converted(h, "1 2"), (std::vector{1, 2}));
  const auto error = get_error(h, text("1 2 3"));
  EXPECT_SAYS(error, "WEIR-2001: a frame does not match input-dim and input-type");
  EXPECT_SAYS(error, "dimension is 3, needed is 2");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(ConverterModule, GetsEachMemoryOfABuffer) {
  auto h = harness("", kNumbers);
  auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(h.get(), gst_buffer_append(text("1 2"), text("3 4"))));
  EXPECT_EQ(values(out.get()), (std::vector{1, 23, 4}));
}

TEST(ConverterModule, MayChangeTheTime) {
  auto h = harness("", kNumbers);
  for (const char* words : {"1", "time"}) {
    GstBuffer* in = text(words);
    GST_BUFFER_PTS(in) = 7;
    GST_BUFFER_DURATION(in) = 3;
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    const bool changed = std::string(words) == "time";
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), changed ? 8u : 7u);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), changed ? 2u : 3u);
  }
}

TEST(ConverterModule, MayDropAFrameWhichIsCounted) {
  auto h = harness("", kNumbers);
  EXPECT_EQ(gst_harness_push(h.get(), text("drop")), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 0u);
  EXPECT_EQ(stat(h, "dropped-policy"), 1u);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(ConverterModule, ThatFailsIsAnErrorWithItsWords) {
  auto h = harness("", kNumbers);
  const std::pair<const char*, const char*> faults[] = {
      {"failure", "WEIR-1004: failed as ordered"},
      {"exception",
       "WEIR-5003: a class in C++ threw an exception\n  offered: thrown in a converter"},
      {"memory", "WEIR-9001: memory ran out in a module"},
      {"number", "offered: not derived from std::exception"},
      {"nothing", "WEIR-5003: the converter numbers produced no tensors"},
      {"many", "WEIR-2006: a frame has too many tensors"},
      {"", "WEIR-2004: a buffer is empty"},
      {"no numbers", "WEIR-2006: a converter describes an invalid tensor"},
  };
  for (const auto& [words, error] : faults) EXPECT_SAYS(get_error(h, text(words)), error);
  EXPECT_EQ(stat(h, "dropped-error"), std::size(faults));
  EXPECT_EQ(converted(h, "4"), std::vector{4}) << "and goes on";
}

TEST(ConverterModule, ForgetsAtAFlushAndAtOtherCaps) {
  auto h = harness("", kNumbers);
  EXPECT_EQ(converted(h, "count"), std::vector{1});
  EXPECT_EQ(converted(h, "count"), std::vector{2});
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(converted(h, "count"), std::vector{1});
  EXPECT_EQ(change_caps(h, "application/x-numbers,framerate=20/1"), "");
  EXPECT_EQ(converted(h, "count"), std::vector{1});
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)20/1");
}

TEST(ConverterModule, MayRefuseCaps) {
  const auto text = caps_error("", std::string(kNumbers) + ",mode=refused");
  EXPECT_SAYS(text, "WEIR-1004: these caps are refused");
  EXPECT_SAYS(text, "fix: mode=(string)accepted");
}

TEST(ConverterModule, MaySayTheFrameRate) {
  auto h = harness("", kNumbers);
  EXPECT_EQ(converted(h, "1"), std::vector{1});
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
  EXPECT_EQ(converted(h, "rate"), std::vector{25});
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)25/1");
  EXPECT_EQ(converted(h, "2"), std::vector{2}) << "a frame without tensors changes nothing";
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)25/1");
  const auto error = get_error(h, text("no rate"));
  EXPECT_SAYS(error, "WEIR-5003: the converter numbers declares an invalid frame rate");
  EXPECT_SAYS(error, "offered: 25/0");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(ConverterModule, HasItsFramesGathered) {
  auto h = harness("frames-per-tensor=3", std::string(kNumbers) + ",shape=three");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:3, types=(string)int32");
  for (uint64_t i = 0; i < 6; ++i) {
    GstBuffer* in = text(std::to_string(i) + " 8 9");
    GST_BUFFER_PTS(in) = i * 100 * GST_MSECOND;
    ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  }
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:3, types=(string)int32");
  for (const int first : {0, 3}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(values(out.get()), (std::vector{first, 8, 9, first + 1, 8, 9, first + 2, 8, 9}));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), static_cast<uint64_t>(first) * 100 * GST_MSECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 300 * GST_MSECOND);
    EXPECT_EQ(gst_buffer_n_memory(out.get()), 1u);
  }
  EXPECT_EQ(stat(h, "consumed"), 6u);
}

TEST(ConverterModule, LosesInTheOpenWhatWaitsWhenItsTensorsChange) {
  auto h = harness("frames-per-tensor=2", kNumbers);
  for (const char* words : {"1 2", "3 4", "5 6", "7", "8"})
    ASSERT_EQ(gst_harness_push(h.get(), text(words)), GST_FLOW_OK);
  auto pairs = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(values(pairs.get()), (std::vector{1, 2, 3, 4}));
  auto singles = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(values(singles.get()), (std::vector{7, 8}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1:2, types=(string)int32");
  EXPECT_EQ(stat(h, "dropped-flush"), 1u);
  EXPECT_EQ(stat(h, "consumed"), 4u);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(ConverterModule, CannotHaveSeveralTensorsGathered) {
  auto h = harness("frames-per-tensor=2", kNumbers);
  const auto error = get_error(h, text("1 2;3"));
  EXPECT_SAYS(error, "WEIR-1004: frames with several tensors cannot be combined into one output");
  EXPECT_SAYS(error, "offered: 2 tensors, frames-per-tensor=2");
  EXPECT_EQ(gst_harness_push(h.get(), text("1 2")), GST_FLOW_OK) << "and goes on";
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
  EXPECT_EQ(stat(h, "held"), 1u);
}

TEST(ConverterModule, GetsHeadersWhenDownstreamRequiresThem) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible");
  gst_harness_set_src_caps_str(h.get(), kNumbers);
  for (const char* words : {"1 2", "3"}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), text(words)));
    const Bytes all = content(out.get());
    const auto header = read_tensor_chunk(std::as_bytes(std::span(all)));
    ASSERT_TRUE(header);
    EXPECT_EQ(header->spec.to_string(), words == std::string("3") ? "int32 1" : "int32 2");
    EXPECT_EQ(header->media, MediaType::Tensor);
  }
}

}  // namespace converted_test
