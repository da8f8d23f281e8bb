// tensor_filter with the C engine of tests/support: y = x + 1 on float32 [-1, 4].
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/frame_layout.hpp"

namespace tensor_filter_test {

using namespace weir::test;

constexpr char kCaps[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)4:2,types=float32,framerate=30/1";

std::string model_path() {
  const std::string path = testing::TempDir() + "weir_fake_model.bin";
  std::ofstream(path) << "x";
  return path;
}

std::string line(const std::string& properties = "") {
  return "tensor_filter framework=fake model=" + model_path() + " " + properties;
}

Harness harness(const std::string& launch, const char* caps = kCaps) {
  return make_harness(launch, caps ? caps : "");
}
std::vector<float> floats(GstBuffer* b) {
  return values<float>(b);
}
const std::vector<float> kEight{0, 1, 2, 3, 4, 5, 6, 7};

Ref<GstElement> get_filter(const Harness& h) {
  return Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_filter"));
}

std::string get_error(const std::string& launch, const char* caps = nullptr) {
  return start_error(launch, caps ? caps : "");
}

TEST(TensorFilter, RunsTheModelOnEachFrame) {
  auto h = harness(line());
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(kEight)));
  ASSERT_TRUE(out);
  EXPECT_EQ(floats(out.get()), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}));
}

// A frame in memory that starts `shift` bytes after a multiple of 4096.
GstBuffer* shifted_frame(size_t shift) {
  constexpr size_t kBytes = 8 * sizeof(float);
  GstAllocationParams params;
  gst_allocation_params_init(&params);
  params.align = 4095;
  GstMemory* memory = gst_allocator_alloc(nullptr, shift + kBytes, &params);
  gst_memory_resize(memory, static_cast<gssize>(shift), kBytes);
  GstBuffer* b = gst_buffer_new();
  gst_buffer_append_memory(b, memory);
  gst_buffer_fill(b, 0, kEight.data(), kBytes);
  return b;
}

TEST(TensorFilter, ProvidesMemoryAsTheModelRequests) {
  struct Case {
    const char* custom;
    size_t shift;
    guint64 copied;
  };
  const std::vector<float> expected{1, 2, 3, 4, 5, 6, 7, 8};
  for (const auto& [custom, shift, copied] :
       std::initializer_list<Case>{{"alignment:4096", 0, 0},
                                   {"alignment:64", 4, 32},
                                   {"alignment:0", 4, 0},
                                   {"padding:65536", 0, 32},
                                   {"alignment:256,padding:9000", 256, 32}}) {
    auto h = harness(line(std::string("custom=") + custom));
    for (int i = 1; i <= 3; ++i) {
      auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), shifted_frame(shift)));
      ASSERT_TRUE(out) << custom;
      EXPECT_EQ(floats(out.get()), expected);
      EXPECT_EQ(stat(get_filter(h).get(), "bytes-copied"), copied * static_cast<guint64>(i))
          << custom;
    }
  }
}

TEST(TensorFilter, ProposesItsAllocationUpstream) {
  auto h = harness(line("custom=alignment:512,padding:24"));
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(kCaps));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_allocation(caps.get(), TRUE));
  ASSERT_TRUE(gst_pad_peer_query(h->srcpad, query.get()));
  ASSERT_EQ(gst_query_get_n_allocation_params(query.get()), 1u);
  GstAllocationParams params;
  gst_query_parse_nth_allocation_param(query.get(), 0, nullptr, &params);
  EXPECT_EQ(params.align, 511u);
  EXPECT_EQ(params.padding, 24u);
}

TEST(TensorFilter, RejectsEnginesWithInvalidRequirements) {
  for (const char* custom : {"alignment:3", "alignment:8192", "padding:65537"})
    EXPECT_SAYS(get_error(line(std::string("custom=") + custom)),
                "the engine requires memory that cannot be allocated")
        << custom;
}

TEST(TensorFilter, KeepsTimestamps) {
  auto h = harness(line());
  GstBuffer* in = frame(kEight);
  GST_BUFFER_PTS(in) = 40 * GST_MSECOND;
  GST_BUFFER_DURATION(in) = 20 * GST_MSECOND;
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 40 * GST_MSECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 20 * GST_MSECOND);
}

TEST(TensorFilter, OffersOtherTensorForASingleOutput) {
  auto h = harness(line());
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(kEight)));
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const auto expected = Ref<GstCaps>::adopt(gst_caps_from_string(
      "other/tensor,dimension=(string)4:2,type=(string)float32,framerate=(fraction)30/1"));
  EXPECT_TRUE(gst_caps_is_equal(caps.get(), expected.get()));
}

TEST(TensorFilter, CountsWhatHappensToFrames) {
  auto h = harness(line("custom=drop-at:1"));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_OK);
  const auto filter = get_filter(h);
  EXPECT_EQ(stat(filter.get(), "received"), 5u);
  EXPECT_EQ(stat(filter.get(), "consumed"), 4u);
  EXPECT_EQ(stat(filter.get(), "pushed"), 4u);
  EXPECT_EQ(stat(filter.get(), "dropped-policy"), 1u);
  EXPECT_EQ(stat(filter.get(), "held"), 0u);
  EXPECT_EQ(stat(filter.get(), "invokes"), 5u);
  EXPECT_EQ(stat(filter.get(), "bytes-copied"), 0u);
}

TEST(TensorFilter, AllocatesNoBufferAfterWarmUp) {
  auto h = harness(line());
  for (int i = 0; i < 1000; ++i)
    Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(kEight)));
  EXPECT_EQ(stat(get_filter(h).get(), "pool-allocated"), 1u);
}

TEST(TensorFilter, PrependsInputsToOutputsWhenCombined) {
  auto h = harness(line("output-combination=o0,i0"));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(kEight)));
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(floats(out.get()),
            (std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7, 1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(stat(get_filter(h).get(), "bytes-copied"), 0u);
}

// Sixteen forwarded inputs and an output: the last two are packed into the 16th memory.
TEST(TensorFilter, CombinesMoreTensorsThanABufferHasMemories) {
  std::string dimensions = "4:1", types = "float32", choice = "i0";
  auto in = Ref<GstBuffer>::adopt(frame<float>({0, 1, 2, 3}));
  for (int i = 1; i < 16; ++i) {
    dimensions += ",4:1", types += ",float32", choice += ",i" + std::to_string(i);
    const float first = 4.0f * static_cast<float>(i);
    in = Ref<GstBuffer>::adopt(
        gst_buffer_append(in.release(), frame<float>({first, first + 1, first + 2, first + 3})));
  }
  const std::string caps = "other/tensors,format=static,num_tensors=16,dimensions=(string)\"" +
                           dimensions + "\",types=(string)\"" + types + "\",framerate=30/1";
  auto h = harness(line("input-combination=15 output-combination=" + choice + ",o0"), caps.c_str());
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in.release()));
  ASSERT_TRUE(out);
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 16u);
  weir::gst::FrameLayout layout;
  weir::FrameSpec spec;
  spec.format = weir::Format::Static;
  spec.tensors.assign(17, weir::TensorSpec{weir::ElementType::Float32, {4}, ""});
  ASSERT_TRUE(layout.locate(out.get(), spec));
  ASSERT_EQ(layout.tensors().size(), 17u);
  for (size_t i = 0; i < 17; ++i) {
    float values[4];
    gst_buffer_extract(out.get(), layout.tensors()[i].offset, values, sizeof values);
    const float first = i < 16 ? 4.0f * static_cast<float>(i) : 61.0f;  // the model adds one
    for (size_t k = 0; k < 4; ++k) EXPECT_EQ(values[k], first + static_cast<float>(k)) << i;
  }
  EXPECT_EQ(stat(get_filter(h).get(), "bytes-copied"), 32u);
}

TEST(TensorFilter, PassesTheChosenInputsToTheModel) {
  auto h = harness(line("input-combination=1"),
                   "other/tensors,format=static,num_tensors=2,dimensions=(string)\"3,4:1\","
                   "types=(string)\"uint8,float32\",framerate=30/1");
  GstBuffer* in = gst_buffer_new_allocate(nullptr, 3, nullptr);
  gst_buffer_append(in, frame<float>({9, 8, 7, 6}));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  ASSERT_TRUE(out);
  EXPECT_EQ(floats(out.get()), (std::vector<float>{10, 9, 8, 7}));
}

TEST(TensorFilter, FollowsTheShapesOfAFlexibleStream) {
  auto h = harness(line(), "other/tensors,format=flexible,framerate=30/1");
  for (const uint32_t rows : {2u, 1u, 3u}) {
    std::vector<float> in(32 + 4 * rows, 5.f);
    const uint32_t head[] = {0xFEEDCCED, 0xDE001000, 7, 4, rows};
    std::memset(in.data(), 0, 128);
    std::memcpy(in.data(), head, sizeof head);
    const uint32_t format_and_media[] = {1, 4};
    std::memcpy(in.data() + 19, format_and_media, 8);
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
    ASSERT_TRUE(out);
    const auto result = floats(out.get());
    ASSERT_EQ(result.size(), 32 + 4 * rows);
    EXPECT_EQ(result.back(), 6.f);
  }
}

TEST(TensorFilter, AcceptsNewCapsMidStream) {
  auto h = harness(line());
  Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(kEight)));
  gst_harness_set_src_caps_str(
      h.get(),
      "other/tensors,format=static,num_tensors=1,dimensions=(string)4:1,types=float32,framerate=30/"
      "1");
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame<float>({1, 1, 1, 1})));
  EXPECT_EQ(floats(out.get()), (std::vector<float>{2, 2, 2, 2}));
}

TEST(TensorFilter, FailsTheStreamWhenTheEngineFails) {
  auto h = harness(line("custom=fail-at:1"));
  EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_ERROR);
  EXPECT_EQ(stat(get_filter(h).get(), "dropped-error"), 1u);
}

TEST(TensorFilter, RejectsABufferOfTheWrongSize) {
  auto h = harness(line());
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3})), GST_FLOW_ERROR);
}

TEST(TensorFilter, RejectsAnInvalidHeader) {
  auto h = harness(line(), "other/tensors,format=flexible,framerate=30/1");
  EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_ERROR);
}

TEST(TensorFilter, ReportsBothShapesWhenTheStreamDoesNotFit) {
  const std::string text = get_error(line(),
                                     "other/tensors,format=static,num_tensors=1,"
                                     "dimensions=(string)5:2,types=float32,framerate=30/1");
  EXPECT_SAYS(text, "WEIR-2001");
  EXPECT_SAYS(text, "offered: 1 tensor: float32 5:2");
  EXPECT_SAYS(text, "needed: 1 tensor: float32 4:?");
  EXPECT_SAYS(text, "dimension 0 is 5, needed is 4");
}

TEST(TensorFilter, SuggestsAPipelineThatFixesAWrongType) {
  const std::string text =
      get_error(line(), "other/tensor,dimension=(string)4:2,type=uint8,framerate=30/1");
  EXPECT_SAYS(text, "fix: tensor_transform mode=typecast option=float32");
}

TEST(TensorFilter, SuggestsTheNearestEngineName) {
  const std::string text =
      get_error("tensor_filter framework=tensorfow-lite model=" + model_path());
  EXPECT_SAYS(text, "WEIR-3001");
  EXPECT_SAYS(text, "did you mean tensorflow-lite?");
}

TEST(TensorFilter, ReportsHowToInstallAMissingEngine) {
  const std::string text = get_error("tensor_filter framework=snpe model=" + model_path());
  EXPECT_SAYS(text, "WEIR-3002");
  EXPECT_SAYS(text, "snpe");
}

TEST(TensorFilter, ReportsAMissingModelFile) {
  const std::string text = get_error("tensor_filter framework=fake model=/nowhere/m.bin");
  EXPECT_SAYS(text, "WEIR-3003");
  EXPECT_SAYS(text, "/nowhere/m.bin");
}

TEST(TensorFilter, RejectsPropertiesWithATypo) {
  EXPECT_SAYS(get_error(line("input-combination=x")), "at \"x\"");
  EXPECT_SAYS(get_error(line("input=5:2")), "input contradicts the model");
  EXPECT_SAYS(get_error(line("output-combination=o3")), "o3");
}

TEST(TensorFilter, NamesModelsToTryWithoutAModel) {
  const std::string text = get_error("tensor_filter framework=fake");
  EXPECT_SAYS(text, "no model is set");
  EXPECT_SAYS(text, "weir models list prints models to try");
  EXPECT_SAYS(text, "fix: model=/path/to/model");
}

TEST(TensorFilter, NamesTheFileOfAnEngineThatIsNotFound) {
  EXPECT_SAYS(get_error("tensor_filter framework=brighten"), "libweir-engine-brighten.so");
  EXPECT_SAYS(get_error("tensor_filter framework=brighten"), "fix: export WEIR_MODULE_PATH=");
  // Where the model's file selects another engine, that one needs no other folder.
  EXPECT_SAYS(get_error("tensor_filter framework=brighten model=m.onnx"), "fix: framework=auto");
}

TEST(TensorFilter, KeepsEventsInTheirPlaceBetweenFrames) {
  auto h = harness(line());
  const auto push_mark = [&](const char* name) {
    gst_harness_push_event(
        h.get(), gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty(name)));
  };
  std::vector<std::string> order;
  const auto note = [](GstPad*, GstPadProbeInfo* info, gpointer data) {
    auto* list = static_cast<std::vector<std::string>*>(data);
    if (info->type & GST_PAD_PROBE_TYPE_BUFFER)
      list->emplace_back("frame");
    else if (const auto* s = gst_event_get_structure(GST_PAD_PROBE_INFO_EVENT(info));
             s && GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_CUSTOM_DOWNSTREAM)
      list->emplace_back(gst_structure_get_name(s));
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(
      h->sinkpad, GstPadProbeType(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM),
      note, &order, nullptr);
  gst_harness_push(h.get(), frame(kEight));
  push_mark("a");
  gst_harness_push(h.get(), frame(kEight));
  push_mark("b");
  EXPECT_EQ(order, (std::vector<std::string>{"frame", "a", "frame", "b"}));
}

TEST(TensorFilter, RejectsBuffersWhileFlushingAndContinuesAfterwards) {
  auto h = harness(line());
  EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_OK);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_FLUSHING);
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(gst_harness_push(h.get(), frame(kEight)), GST_FLOW_OK);
  const auto element = get_filter(h);
  EXPECT_EQ(stat(element.get(), "received"), stat(element.get(), "consumed"));
  EXPECT_EQ(stat(element.get(), "held"), 0u);
}

// tensor_filter posts the error instead of a plain "not negotiated" of the upstream elements.
TEST(TensorFilter, ReportsWhatItNeedsDownstreamOfAnIncompatibleCapsfilter) {
  const std::string text = error_of_pipeline(
      "videotestsrc num-buffers=1 ! video/x-raw,format=GRAY8,width=5,height=3 ! tensor_converter "
      "! " +
      line() + " ! fakesink");
  EXPECT_SAYS(text, "WEIR-2001");
  EXPECT_SAYS(text, "needed: ");
}

// An engine that is a C++ class based on weir/engine.hpp.
std::string scaling(const std::string& options) {
  return "tensor_filter framework=scaling model=" + model_path() + " custom=" + options;
}
constexpr char kFour[] = "other/tensor,dimension=(string)4,type=float32,framerate=30/1";

TEST(TensorFilter, RunsAnEngineWrittenInCpp) {
  auto h = harness(scaling("factor:-2.5"), kFour);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame<float>({1, 2, 0, -4})));
  EXPECT_EQ(floats(out.get()), (std::vector<float>{-2.5, -5, -0.0, 10}));
}

TEST(TensorFilter, ConvertsExceptionsOfSuchAnEngineToErrors) {
  EXPECT_SAYS(get_error(scaling("factor:much")), "WEIR-1004: factor is no number");
  auto h = harness(scaling("throw-at:1"), kFour);
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4})), GST_FLOW_OK);
  {
    Errors errors(get_filter(h).get());
    EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4})), GST_FLOW_ERROR);
    const std::string error = errors.next();
    EXPECT_EQ(error.find("WEIR-5003: a class in C++ threw an exception"), 0u)
        << error << ": not a fault of Weir";
    EXPECT_SAYS(error, "offered: thrown in an engine");
  }
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4})), GST_FLOW_OK)
      << "the next frame runs";
}

}  // namespace tensor_filter_test
