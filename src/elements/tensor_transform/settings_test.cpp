// tensor_transform used by several threads: properties, queries, stats and state changes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "elements/tests/element_test_support.hpp"
#include "elements/tests/second_thread_test_support.hpp"

namespace settings_test {

using namespace weir::test;

constexpr char kFloats[] = "other/tensor,dimension=(string)4,type=(string)float32,framerate=30/1";

std::string output_type(GstElement* element) {
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(element, "src"));
  const auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(source.get(), nullptr));
  const char* type = gst_structure_get_string(gst_caps_get_structure(caps.get(), 0), "type");
  return type ? type : "";
}

TEST(TensorTransformSettings, StatsCanBeReadDuringARestart) {
  auto h = make_harness("tensor_transform mode=typecast option=uint8", kFloats);
  const auto element = find_element(h, "tensor_transform");
  std::atomic<uint64_t> max = 0;
  SecondThread reader([&] { max = std::max(max.load(), stat(element.get(), "pool-allocated")); });
  for (int round = 0; round < 100; ++round) {
    gst_element_set_state(element.get(), GST_STATE_READY);
    gst_element_set_state(element.get(), GST_STATE_PLAYING);
  }
}

TEST(TensorTransformSettings, StatsStillShowThePoolAfterTheEnd) {
  auto h = make_harness("tensor_transform mode=typecast option=uint8", kFloats);
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(std::vector<float>(4))));
  EXPECT_EQ(stat(h, "tensor_transform", "pool-allocated"), 1u);
  gst_element_set_state(find_element(h, "tensor_transform").get(), GST_STATE_READY);
  EXPECT_EQ(stat(h, "tensor_transform", "pool-allocated"), 1u);
}

TEST(TensorTransformSettings, QueriesFollowTheOptionThatWasSetLast) {
  const auto element = lone_element("tensor_transform mode=typecast option=uint8");
  SecondThread reader([&] { output_type(element.get()); });
  for (int round = 0; round < 300; ++round)
    for (const char* type : {"int16", "float64"}) {
      g_object_set(element.get(), "option", type, nullptr);
      ASSERT_EQ(output_type(element.get()), type) << "round " << round;
    }
}

std::string option_of(GstElement* element) {
  gchar* option = nullptr;
  g_object_get(element, "option", &option, nullptr);
  const weir::gst::UniqueText owned(option);
  return option ? option : "NULL";
}

// docs/compatibility/programs.md 11.2.
TEST(TensorTransformSettings, AnOptionThatDoesNotFitTheModeIsRefused) {
  const auto element = lone_element("tensor_transform mode=dimchg");
  Errors errors(element.get());
  g_object_set(element.get(), "option", "20:21", nullptr);
  EXPECT_EQ(option_of(element.get()), "NULL");
  EXPECT_SAYS(errors.next_warning(), "20:21");
  g_object_set(element.get(), "option", "0:2", nullptr);
  g_object_set(element.get(), "option", "20:21", nullptr);
  EXPECT_EQ(option_of(element.get()), "0:2") << "the one before";
  const auto transpose = lone_element("tensor_transform mode=transpose option=0:3");
  EXPECT_EQ(option_of(transpose.get()), "NULL") << "no permutation";
  const auto early = lone_element("tensor_transform option=0:3 mode=transpose");
  EXPECT_EQ(option_of(early.get()), "0:3") << "it was set before the mode";
}

TEST(TensorTransformSettings, ARefusedOptionIsReportedAtTheStart) {
  EXPECT_SAYS(start_error("tensor_transform mode=dimchg option=20:21"), "20:21");
}

TEST(TensorTransformSettings, AnInvalidApplyIsReportedAtTheStart) {
  EXPECT_SAYS(start_error("tensor_transform mode=typecast option=uint8 apply=0,y"),
              "WEIR-1001: apply cannot be read\n  offered: 0,y");
}

}  // namespace settings_test
