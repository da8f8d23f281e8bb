// tensor_transform in a harness: values, caps, errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>
#include <vector>

#include "elements/tests/element_test_support.hpp"

namespace tensor_transform_test {

using namespace weir::test;

Harness harness(const std::string& properties, const char* caps) {
  return make_harness("tensor_transform " + properties, caps);
}
constexpr char kBytes[] = "other/tensor,dimension=(string)3:2,type=uint8,framerate=30/1";

template <class T>
std::vector<T> pushed(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  return values<T>(out.get());
}
const std::vector<uint8_t> kSix{0, 1, 2, 127, 200, 255};

TEST(TensorTransform, NormalisesPixels) {
  auto h = harness("mode=arithmetic option=typecast:float32,add:-127.5,div:127.5", kBytes);
  const auto out = pushed<float>(h, frame(kSix));
  ASSERT_EQ(out.size(), 6u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(out[i], (static_cast<float>(kSix[i]) - 127.5f) / 127.5f);
}

TEST(TensorTransform, CastsTypes) {
  auto h = harness("mode=typecast option=int16", kBytes);
  EXPECT_EQ(pushed<int16_t>(h, frame(kSix)), (std::vector<int16_t>{0, 1, 2, 127, 200, 255}));
}

TEST(TensorTransform, ConvertsTheOperandFirstAndSaturates) {
  EXPECT_EQ(pushed<uint8_t>(harness("mode=arithmetic option=mul:0.5", kBytes), frame(kSix)),
            (std::vector<uint8_t>{0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(pushed<uint8_t>(harness("mode=arithmetic option=add:-1.5", kBytes), frame(kSix)),
            (std::vector<uint8_t>{255, 255, 255, 255, 255, 255}));
}

TEST(TensorTransform, AppliesAStepToOneChannel) {
  auto h = harness("mode=arithmetic option=per-channel:true@0,add:10@1,add:20@2", kBytes);
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)), (std::vector<uint8_t>{0, 11, 22, 127, 210, 255}));
}

TEST(TensorTransform, KeepsIntegersAndCountsOnDivisionByZero) {
  auto h = harness("mode=arithmetic option=div:0", kBytes);
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)), kSix);
  EXPECT_EQ(stat(h, "tensor_transform", "integer-divisions-by-zero"), 6u);
}

TEST(TensorTransform, TransposesValuesAndCaps) {
  auto h = harness("mode=transpose option=1:0:2:3", kBytes);
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)), (std::vector<uint8_t>{0, 127, 1, 200, 2, 255}));
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  EXPECT_STREQ(gst_structure_get_string(gst_caps_get_structure(caps.get(), 0), "dimension"), "2:3");
}

TEST(TensorTransform, TransposesMoreThanFourDimensions) {
  auto h = harness("mode=transpose option=4:1:2:3:0",
                   "other/tensor,dimension=(string)2:1:1:1:3,type=uint8,framerate=30/1");
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)), (std::vector<uint8_t>{0, 2, 200, 1, 127, 255}));
}

std::string dimension(const Harness& h) {
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  return gst_structure_get_string(gst_caps_get_structure(caps.get(), 0), "dimension");
}

TEST(TensorTransform, MovesADimension) {
  auto h = harness("mode=dimchg option=0:1", kBytes);
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)), (std::vector<uint8_t>{0, 127, 1, 200, 2, 255}));
  EXPECT_EQ(dimension(h), "2:3");
}

TEST(TensorTransform, LimitsValues) {
  auto h = harness("mode=clamp option=1.5:200", kBytes);
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)), (std::vector<uint8_t>{1, 1, 2, 127, 200, 200}));
}

TEST(TensorTransform, Standardises) {
  auto h = harness("mode=stand option=dc-average:int16,per-channel:true", kBytes);
  EXPECT_EQ(pushed<int16_t>(h, frame(std::vector<uint8_t>{0, 10, 100, 20, 30, 102})),
            (std::vector<int16_t>{-10, -10, -1, 10, 10, 1}));
}

TEST(TensorTransform, PadsWithZeros) {
  auto h = harness("mode=padding option=left:1,bottom:1", kBytes);
  EXPECT_EQ(pushed<uint8_t>(h, frame(kSix)),
            (std::vector<uint8_t>{0, 0, 1, 2, 0, 127, 200, 255, 0, 0, 0, 0}));
  EXPECT_EQ(dimension(h), "4:3");
}

std::string output_format(const std::string& line) {
  Harness h{gst_harness_new_parse(line.c_str())};
  gst_harness_set_src_caps_str(h.get(), kBytes);
  EXPECT_EQ(gst_harness_push(h.get(), frame(kSix)), GST_FLOW_OK);
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const GstStructure* s = gst_caps_get_structure(caps.get(), 0);
  const char* format = gst_structure_get_string(s, "format");
  return format ? format : gst_structure_get_name(s);
}

TEST(TensorTransform, KeepsAStreamStaticUpstreamOfATypeChange) {
  const std::string cast = "tensor_transform mode=typecast option=";
  EXPECT_EQ(output_format(cast + "float16 ! " + cast + "int16"), "other/tensor");
  EXPECT_EQ(output_format(cast + "float16 ! identity ! " + cast + "int16 ! identity"),
            "other/tensor");
  EXPECT_EQ(output_format(cast + "float16 ! " + cast +
                          "int16 ! capsfilter caps=other/tensors,format=flexible"),
            "flexible");
}

TEST(TensorTransform, TransformsOnlyTheChosenTensors) {
  auto h = harness("mode=arithmetic option=add:1 apply=1",
                   "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,3\","
                   "types=(string)\"uint8,uint8\",framerate=30/1");
  GstBuffer* in = frame(std::vector<uint8_t>{7, 8});
  gst_buffer_append(in, frame(std::vector<uint8_t>{1, 2, 3}));
  EXPECT_EQ(pushed<uint8_t>(h, in), (std::vector<uint8_t>{7, 8, 2, 3, 4}));
}

TEST(TensorTransform, RejectsABufferOfTheWrongSize) {
  auto h = harness("mode=typecast option=float32", kBytes);
  EXPECT_EQ(gst_harness_push(h.get(), frame(std::vector<uint8_t>{1, 2})), GST_FLOW_ERROR);
}

std::string get_error(const std::string& properties) {
  return start_error("tensor_transform " + properties);
}

TEST(TensorTransform, ReportsThePositionOfATypo) {
  const std::string text = get_error("mode=arithmetic option=typecast:float32,ad:1");
  EXPECT_SAYS(text, "WEIR-1001");
  EXPECT_SAYS(text, "at character 18");
}

TEST(TensorTransform, RejectsUnreadableOptions) {
  for (const char* properties :
       {"mode=typecast option=float23", "mode=arithmetic option=add",
        "mode=arithmetic option=add:x", "mode=arithmetic option=add:1,,mul:2",
        "mode=arithmetic option=per-channel:true@x,add:1", "mode=arithmetic option=add:1@-1",
        "mode=dimchg option=0", "mode=stand option=mean", "mode=clamp option=1",
        "mode=padding option=lft:1", "mode=transpose option=0:0:1:3", "mode=transpose option=1:2",
        "mode=transpose option=x", "mode=typecast option=int8 apply=x"})
    EXPECT_SAYS(get_error(properties), "WEIR-1001") << properties;
}

}  // namespace tensor_transform_test
