// Tests of tensor_filter with filter sub-plugins of NNStreamer's interface, found in the folders of
// nnstreamer.ini.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "filter_lines_test_support.hpp"
#include "nnstreamer_plugin_api_filter.h"

namespace sub_plugin_test {

using namespace weir::test;
using Floats = std::vector<float>;
using Numbers = std::vector<int32_t>;

const std::string kThree = tensors("uint8", "3");

std::string header1(const std::string& more) {
  return "tensor_filter framework=header1 " + more;
}

TEST(CompatSubPlugin, Version0WithTheDocumentedLayoutFollowsTheStream) {
  auto h = make_harness("tensor_filter framework=hand0", tensors("int32", "2:2"));
  EXPECT_EQ(pushed<int32_t>(h, {1, -2, 3, 40}), (Numbers{2, -4, 6, 80}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)2:2");
}

TEST(CompatSubPlugin, Version0RejectsInputsWithItsNumber) {
  auto h = make_harness("tensor_filter framework=hand0");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), tensors("int8", "2").c_str());
  gst_harness_push(h.get(), frame<int8_t>({1, 2}));
  const auto message = errors.next();
  EXPECT_SAYS(message, "the filter hand0 rejects the inputs of the stream");
  EXPECT_SAYS(message, "-22 (Invalid argument)");
}

TEST(CompatSubPlugin, Version1TransfersItsMemory) {
  auto h = make_harness(header1(""), kThree);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2, 3}), (Bytes{3, 2, 1}));
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u);
}

TEST(CompatSubPlugin, ReportsItsHardware) {
  const auto has = gst_tensor_filter_check_hw_availability;
  for (const auto hw : {ACCL_CPU_SIMD, ACCL_NPU, ACCL_GPU})
    EXPECT_TRUE(has("header1", hw, nullptr));
  EXPECT_FALSE(has("header1", ACCL_NPU_SLSI, nullptr)) << "it is not in its list";
  EXPECT_TRUE(has("header1", ACCL_NPU_EDGETPU, "usb")) << "asked by the event";
  EXPECT_FALSE(has("header1", ACCL_NPU_EDGETPU, "pci"));
  EXPECT_FALSE(has("hand0", ACCL_GPU, nullptr)) << "it has no checkAvailability";
}

TEST(CompatSubPlugin, RunsInItsOwnProcess) {
  auto h = make_harness(header1("isolate=process"), kThree);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2, 3}), (Bytes{3, 2, 1}));
}

TEST(CompatSubPlugin, BatchesCopyWhatItAllocates) {
  auto h = make_harness(header1("workers=2"), kThree);
  ASSERT_EQ(gst_harness_push(h.get(), frame<uint8_t>({1, 2, 3})), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{3, 2, 1}));
}

TEST(CompatSubPlugin, DecidesSizesWithEachFrame) {
  auto h = make_harness(header1("custom=dynamic invoke-dynamic=true"), kThree);
  for (const uint8_t count : {uint8_t{2}, uint8_t{5}}) {
    const auto out = pushed<uint8_t>(h, {count, 0, 0});
    ASSERT_EQ(out.size(), 128u + count);
    EXPECT_EQ(Bytes(out.begin() + 128, out.end()), Bytes(count, count));
  }
  EXPECT_SAYS(frame_error<uint8_t>(h, {0, 0, 0}), "output 0 with the dimension 0");
}

TEST(CompatSubPlugin, DecidesTheirNumberWithEachFrame) {
  for (const char* more : {"", " isolate=process"}) {
    auto h =
        make_harness(header1(std::string("custom=dynamic invoke-dynamic=true") + more), kThree);
    for (const guint count : {1u, 2u, 1u}) {
      const auto first = static_cast<uint8_t>(count == 2 ? 7 : 3);
      ASSERT_EQ(gst_harness_push(h.get(), frame<uint8_t>({first, 0, 0})), GST_FLOW_OK);
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      EXPECT_EQ(gst_buffer_n_memory(out.get()), count) << more;
    }
  }
}

TEST(CompatSubPlugin, AnswersAsynchronously) {
  auto h = make_harness(header1("custom=async invoke-async=true"), kThree);
  ASSERT_EQ(gst_harness_push(h.get(), frame<uint8_t>({7, 8, 9})), GST_FLOW_OK);
  for (const uint8_t number : {uint8_t{7}, uint8_t{8}, uint8_t{9}}) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), Bytes(3, number));
  }
}

Numbers hardware(const std::string& more) {
  auto h = make_harness(header1("custom=hardware " + more), kThree);
  return pushed<uint8_t, int32_t>(h, {1, 2, 3});
}

TEST(CompatSubPlugin, ReceivesAccelerators) {
  EXPECT_EQ(hardware(""), (Numbers{1, 0x1100, -1, -1}));
  EXPECT_EQ(hardware("accelerator=false"), (Numbers{1, 0, -1, -1}));
  EXPECT_EQ(hardware("accelerator=true"), (Numbers{1, 0x4000, -1, -1}));
  EXPECT_EQ(hardware("accelerator=true:npu.edgetpu,gpu,cpu.neon"),
            (Numbers{2, 0x2000, 0x1100, -1}));
  EXPECT_EQ(hardware("accelerator=true:!gpu,gpu,npu"), (Numbers{1, 0x4000, -1, -1}));
}

TEST(CompatSubPlugin, ReceivesProperties) {
  auto h =
      make_harness(header1("custom=properties latency=1 suspend=1234 inputlayout=nhwc"), kThree);
  EXPECT_EQ((pushed<uint8_t, int32_t>(h, {1, 2, 3})), (Numbers{1, 1234, 1, 1}));
}

TEST(CompatSubPlugin, ClassAddsANumber) {
  auto h = make_harness("tensor_filter framework=classes custom=1.5", tensors("float32", "2"));
  EXPECT_EQ(pushed<float>(h, {1, 2}), (Floats{2.5, 3.5}));
  const auto message = frame_error<float>(h, {13, 0});
  EXPECT_SAYS(message, "the filter classes failed on a frame");
  EXPECT_SAYS(message, "-22 (Invalid argument)");
}

TEST(CompatSubPlugin, ClassReportsThatItCannotBeConfigured) {
  EXPECT_SAYS(start_error("tensor_filter framework=classes custom=throw"),
              "the filter classes cannot open its model\n  offered: open returned -22");
  EXPECT_SAYS(start_error("tensor_filter framework=classes custom=device"),
              "open returned -19 (No such device)");
}

TEST(CompatSubPlugin, IsListedWithTheEngines) {
  const auto filter = Ref<GstElement>::adopt(gst_element_factory_make("tensor_filter", nullptr));
  gst_object_ref_sink(filter.get());
  char* list = nullptr;
  g_object_get(filter.get(), "sub-plugins", &list, nullptr);
  const std::string names = list;
  g_free(list);
  for (const char* name : {"hand0", "header1", "classes"}) EXPECT_SAYS(names, name);
}

TEST(CompatSubPlugin, FaultyDescriptorsAreRejected) {
  make_harness("tensor_filter framework=hand0", tensors("int32", "1"));  // has that name
  const std::pair<int, const char*> faults[] = {
      {0, "version 0xdeafdead00020000"},
      {1, "version 0x0000000000000001"},
      {2, "no name"},
      {3, "this name is reserved (ANY)"},
      {4, "another filter already has this name (hand0)"},
      {5, "no invoke_NN"},
      {6, "no function that declares the tensors"},
      {7, "only one of getInputDimension and getOutputDimension"},
      {8, "getFrameworkInfo returned -5"},
      {9, "no eventHandler"}};
  for (const auto& [number, words] : faults) {
    const auto message = start_error("tensor_filter framework=faulty" + std::to_string(number));
    EXPECT_SAYS(message, "WEIR-3007");
    EXPECT_SAYS(message, words);
    EXPECT_SAYS(message, number == 4 ? "fix: " : "fix: correct the rejected part and rebuild");
  }
}

}  // namespace sub_plugin_test
