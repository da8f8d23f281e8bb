// Tests of tensor_if compared-value=CUSTOM with conditions that a program registers with
// NNStreamer's function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/branches_test_support.hpp"
#include "sub_plugin_test_support.hpp"
#include "tensor_if.h"

namespace weir::test {
namespace sub_plugin_conditions_test {

constexpr char kNamed[] = "tensor_if compared-value=CUSTOM compared-value-option=c-named";

// Whether the first byte of the second tensor is 7; fails if the first tensor starts with 255.
bool second_is_seven(const GstTensorsInfo* info, const GstTensorMemory* input, void* data,
                     bool* result) {
  ++*static_cast<int*>(data);
  EXPECT_EQ(info->num_tensors, 2u);
  EXPECT_EQ(info->format, _NNS_TENSOR_FORMAT_STATIC);
  EXPECT_EQ(info->info[0].type, _NNS_UINT8);
  EXPECT_EQ(info->info[1].type, _NNS_INT16);
  EXPECT_EQ(info->info[1].dimension[0], 1u);
  EXPECT_EQ(info->info[1].dimension[1], 3u);
  EXPECT_EQ(info->info[1].dimension[2], 0u);
  EXPECT_EQ(input[0].size, 2u);
  EXPECT_EQ(input[1].size, 6u);
  if (static_cast<const uint8_t*>(input[0].data)[0] == 255) return false;
  *result = static_cast<const uint8_t*>(input[1].data)[0] == 7;
  return true;
}

TEST(SubPluginCondition, DecidesByAllTensorsOfTheFrame) {
  int calls = 0;
  const auto add = WEIR_LIBRARY(nnstreamer_if_custom_register);
  const auto remove = WEIR_LIBRARY(nnstreamer_if_custom_unregister);
  ASSERT_EQ(add("c-named", second_is_seven, &calls), 0);
  Branches element(kNamed);
  element.caps(test::tensors("uint8,int16", "2:1,1:3"));
  ASSERT_EQ(element.push(make_frame({{1, 2}, {7, 0, 0, 0, 0, 0}})), GST_FLOW_OK);
  ASSERT_EQ(element.push(make_frame({{3, 4}, {6, 0, 0, 0, 0, 0}})), GST_FLOW_OK);
  EXPECT_EQ(content(element.take("src_0").get(), 0), (Bytes{1, 2}));
  EXPECT_EQ(content(element.take("src_1").get(), 0), (Bytes{3, 4}));
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(element.push(make_frame({{255, 4}, {6, 0, 0, 0, 0, 0}})), GST_FLOW_ERROR);
  const auto error = element.error();
  EXPECT_SAYS(error, "WEIR-5003: the condition c-named failed: it returned false");
  EXPECT_SAYS(error, "needed: true, with the answer in *result");
  EXPECT_EQ(remove("c-named"), 0);
}

TEST(SubPluginCondition, RequiresAnUnusedName) {
  int calls = 0;
  const auto add = WEIR_LIBRARY(nnstreamer_if_custom_register);
  const auto remove = WEIR_LIBRARY(nnstreamer_if_custom_unregister);
  ASSERT_EQ(add("c-twice", second_is_seven, &calls), 0);
  EXPECT_EQ(add("c-twice", second_is_seven, &calls), -EINVAL);
  EXPECT_EQ(remove("c-twice"), 0);
  EXPECT_EQ(remove("c-twice"), -EINVAL);
  EXPECT_EQ(add("c-twice", second_is_seven, &calls), 0) << "free again";
  EXPECT_EQ(remove("c-twice"), 0);
  EXPECT_EQ(add("", second_is_seven, &calls), -EINVAL);
  EXPECT_EQ(add("ANY", second_is_seven, &calls), -EINVAL);
  EXPECT_EQ(add(nullptr, second_is_seven, &calls), -EINVAL);
  EXPECT_EQ(add("c-none", nullptr, &calls), -EINVAL);
  EXPECT_EQ(remove(nullptr), -EINVAL);
  Branches element("tensor_if compared-value=CUSTOM");
  g_object_set(element.element(), "compared-value-option", "c-twice", nullptr);
  EXPECT_SAYS(element.warning(), "WEIR-5002: no condition is registered under this name");
}

}  // namespace sub_plugin_conditions_test
}  // namespace weir::test
