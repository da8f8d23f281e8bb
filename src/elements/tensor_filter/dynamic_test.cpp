// invoke-dynamic: outputs whose size the model decides with each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tests/element_test_support.hpp"

namespace dynamic_test {

using namespace weir::test;

constexpr size_t kHeaderWords = 32;

std::string filter(const std::string& framework, const std::string& properties) {
  const std::string path = testing::TempDir() + "weir_dynamic_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=" + framework + " model=" + path + " " + properties;
}
const std::string kFour = tensors("float32", "4:1");

// A flexible tensor: the 32-bit words of its header (docs/compatibility/types-and-caps.md 1.7) and
// the payload.
struct Flexible {
  std::vector<uint32_t> header;
  std::vector<float> values;
};
Flexible flexible(GstBuffer* b) {
  EXPECT_EQ(gst_buffer_n_memory(b), 1u);
  Flexible out{values<uint32_t>(b), values<float>(b)};
  out.header.resize(kHeaderWords);
  out.values.erase(out.values.begin(), out.values.begin() + kHeaderWords);
  return out;
}
// Magic, version, type float32, dimensions innermost-first, format and media.
std::vector<uint32_t> make_header(std::vector<uint32_t> dimensions, uint32_t format) {
  std::vector<uint32_t> out(kHeaderWords);
  out[0] = 0xFEEDCCED;
  out[1] = 0xDE001000;
  out[2] = 7;
  std::copy(dimensions.begin(), dimensions.end(), out.begin() + 3);
  out[19] = format;
  out[20] = 4;  // media: tensor
  return out;
}

TEST(TensorFilterDynamic, UsesTheSizeThatTheModelDecides) {
  auto h = make_harness(filter("fake-async", "invoke-dynamic=true custom=dynamic:1"), kFour);
  for (const uint32_t rows : {3u, 1u, 2u, 5u}) {
    const auto first = static_cast<float>(rows);
    GstBuffer* in = frame<float>({first, 7, 8, 9}, rows * GST_SECOND, GST_MSECOND);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    ASSERT_TRUE(out);
    const auto tensor = flexible(out.get());
    EXPECT_EQ(tensor.header, make_header({4, rows}, 1));
    ASSERT_EQ(tensor.values.size(), 4 * rows);
    for (uint32_t row = 0; row < rows; ++row) {
      EXPECT_EQ(tensor.values[4 * row], first);
      EXPECT_EQ(tensor.values[4 * row + 3], 9.f);
    }
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), rows * GST_SECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), GST_MSECOND);
  }
  EXPECT_SAYS(caps_text(h), "format=(string)flexible");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)30/1");
}

// A model with fixed outputs also supports this.
TEST(TensorFilterDynamic, ConvertsFixedOutputsToFlexibleTensors) {
  auto h = make_harness(filter("fake", "invoke-dynamic=true"), kFour);
  for (int i = 0; i < 20; ++i) {
    const auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(h.get(), frame<float>({1, 2, 3, static_cast<float>(i)})));
    const auto tensor = flexible(out.get());
    EXPECT_EQ(tensor.header, make_header({4, 1}, 1));
    EXPECT_EQ(tensor.values, (std::vector<float>{2, 3, 4, static_cast<float>(i + 1)}));
  }
  EXPECT_SAYS(caps_text(h), "format=(string)flexible");
  EXPECT_EQ(stat(h, "tensor_filter", "pool-allocated"), 1u);
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u);
}

TEST(TensorFilterDynamic, WritesStaticInTheHeaderWithoutTheProperty) {
  auto h =
      make_harness(filter("fake", "") + " ! capsfilter caps=other/tensors,format=flexible", kFour);
  const auto out =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame<float>({1, 2, 3, 4})));
  EXPECT_EQ(flexible(out.get()).header, make_header({4, 1}, 0));
}

TEST(TensorFilterDynamic, OffersOnlyFlexibleTensors) {
  auto h = make_harness(filter("fake", "invoke-dynamic=true"), kFour);
  const auto caps = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(h->sinkpad, nullptr));
  ASSERT_GT(gst_caps_get_size(caps.get()), 0u);
  for (guint i = 0; i < gst_caps_get_size(caps.get()); ++i)
    EXPECT_STREQ(gst_structure_get_string(gst_caps_get_structure(caps.get(), i), "format"),
                 "flexible");
}

TEST(TensorFilterDynamic, CombinesInputsWithDynamicOutputs) {
  auto h = make_harness(
      filter("fake-async", "invoke-dynamic=true custom=dynamic:1 output-combination=i0,o0"), kFour);
  const auto out =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame<float>({2, 2, 3, 4})));
  ASSERT_TRUE(out);
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 2u);
  const auto all = values<uint32_t>(out.get());
  ASSERT_EQ(all.size(), 2 * kHeaderWords + 4 + 8);
  EXPECT_EQ(all[3 + 1], 1u) << "rows of the input";
  EXPECT_EQ(all[kHeaderWords + 4 + 3 + 1], 2u) << "rows of the output";
}

// Another model that accepts any size can process the tensors.
TEST(TensorFilterDynamic, FeedsAModelThatAcceptsAnySize) {
  auto h = make_harness(
      filter("fake-async", "invoke-dynamic=true custom=dynamic:1") + " ! " + filter("fake", ""),
      kFour);
  for (const float rows : {3.f, 1.f}) {
    const auto out =
        Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame<float>({rows, 7, 8, 9})));
    const auto tensor = flexible(out.get());
    EXPECT_EQ(tensor.header, make_header({4, static_cast<uint32_t>(rows)}, 0));
    EXPECT_EQ(tensor.values.back(), 10.f);
  }
}

TEST(TensorFilterDynamic, ReportsADownstreamThatRejectsFlexibleTensors) {
  auto h = make_harness(filter("fake", "invoke-dynamic=true") +
                        " ! capsfilter caps=other/tensors,format=static");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kFour.c_str());
  const std::string text = errors.next();
  EXPECT_SAYS(text,
              "WEIR-2001: the element downstream of tensor_filter does not accept its output");
  EXPECT_SAYS(text, "fix: other/tensors,format=flexible");
}

TEST(TensorFilterDynamic, ReportsAModelThatChangesANegotiatedSize) {
  auto h = make_harness(filter("fake-async", "custom=other-shape:1"), kFour);
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4})), GST_FLOW_ERROR);
  const std::string text = errors.next();
  EXPECT_SAYS(text, "WEIR-3006: the model changed the size of an output");
  EXPECT_SAYS(text, "offered: float32 4:2");
  EXPECT_SAYS(text, "needed: float32 4:1");
  EXPECT_SAYS(text, "first difference: tensor 0");
  EXPECT_SAYS(text, "fix: tensor_filter invoke-dynamic=true");
}

TEST(TensorFilterDynamic, RejectsInvalidOutputs) {
  struct Case {
    const char* custom;
    const char* message;
  };
  for (const auto& [custom, message] :
       {Case{"wrong-size:1", "the size of the engine's output does not match its shape"},
        Case{"no-memory:1", "the engine returned no memory for an output"}}) {
    auto h = make_harness(
        filter("fake-async", std::string("invoke-dynamic=true custom=dynamic:1,") + custom), kFour);
    Errors errors(h);
    EXPECT_EQ(gst_harness_push(h.get(), frame<float>({2, 2, 3, 4})), GST_FLOW_ERROR);
    EXPECT_SAYS(errors.next(), message);
  }
}

}  // namespace dynamic_test
