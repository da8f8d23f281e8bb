// tensor_merge whose dimension changes while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_mux/many_inputs_test_support.hpp"

namespace weir::test {
namespace tensor_merge_tuning_test {

constexpr char kCaps[] =
    "other/tensor,dimension=(string)2:1,type=(string)uint8,framerate=(fraction)30/1";

std::string option(const ManyInputs& merge) {
  gchar* raw = nullptr;
  g_object_get(merge.element(), "option", &raw, nullptr);
  const gst::UniqueText text{raw};
  return text.get();
}

TEST(MergePropertyChange, NewDimensionAppliesToTheNextFrame) {
  ManyInputs merge("tensor_merge mode=linear option=0");
  merge.add(kCaps);
  merge.add(kCaps);
  merge.play();
  merge.push_all({{1, 2}, {3, 4}}, 0);
  EXPECT_SAYS(merge.caps(), "dimensions=(string)4:1");
  g_object_set(merge.element(), "option", "1", nullptr);
  merge.push_all({{1, 2}, {3, 4}}, 40);
  EXPECT_SAYS(merge.caps(), "dimensions=(string)2:2");
  EXPECT_EQ(merge.warning(), "");
}

TEST(MergePropertyChange, InvalidValuesAreRejectedAndRestored) {
  ManyInputs merge("tensor_merge mode=linear option=0");
  merge.add(kCaps);
  merge.add("other/tensor,dimension=(string)3:1,type=(string)uint8,framerate=(fraction)30/1");
  merge.play();
  merge.push_all({{1, 2}, {3, 4, 5}}, 0);
  g_object_set(merge.element(), "option", "x", nullptr);
  EXPECT_EQ(option(merge), "0");
  EXPECT_SAYS(merge.warning(), "option is not a dimension");
  g_object_set(merge.element(), "mode", "stacked", nullptr);
  EXPECT_SAYS(merge.warning(), "mode is not known");
  g_object_set(merge.element(), "option", "1", nullptr);
  merge.push_all({{1, 2}, {3, 4, 5}}, 40);
  EXPECT_SAYS(merge.warning(), "WEIR-");
  EXPECT_EQ(option(merge), "0");
  EXPECT_SAYS(merge.caps(), "dimensions=(string)5:1");
  EXPECT_EQ(merge.error(), "");
}

TEST(MergePropertyChange, ARejectedOptionIsRestoredAsWritten) {
  ManyInputs merge("tensor_merge mode=linear option=00");
  merge.add(kCaps);
  merge.add("other/tensor,dimension=(string)3:1,type=(string)uint8,framerate=(fraction)30/1");
  merge.play();
  merge.push_all({{1, 2}, {3, 4, 5}}, 0);
  g_object_set(merge.element(), "option", "1", nullptr);
  merge.push_all({{1, 2}, {3, 4, 5}}, 40);
  EXPECT_SAYS(merge.warning(), "WEIR-");
  EXPECT_EQ(option(merge), "00");
  EXPECT_EQ(merge.error(), "");
}

TEST(MergePropertyChange, InvalidValuesAtTheStartAreKept) {
  ManyInputs merge("tensor_merge mode=linear option=1");
  merge.add(kCaps);
  merge.add("other/tensor,dimension=(string)3:1,type=(string)uint8,framerate=(fraction)30/1");
  merge.play();
  auto first = merge.push_later(0, {1, 2}, 0);
  merge.push(1, {3, 4, 5}, 0);
  EXPECT_EQ(first.wait_for(kMaxWait), std::future_status::ready);
  EXPECT_SAYS(merge.error(), "WEIR-");
  EXPECT_EQ(option(merge), "1");
}

TEST(MergePropertyChange, OutputThatDownstreamRejectsIsRejected) {
  ManyInputs merge("tensor_merge mode=linear option=0",
                   "other/tensor,dimension=(string)4:1,type=(string)uint8,framerate=30/1");
  merge.add(kCaps);
  merge.add(kCaps);
  merge.play();
  merge.push_all({{1, 2}, {3, 4}}, 0);
  g_object_set(merge.element(), "option", "1", nullptr);
  merge.push_all({{5, 6}, {7, 8}}, 40);
  const std::string warning = merge.warning();
  EXPECT_SAYS(warning, "2:2");
  EXPECT_SAYS(warning, "fix: tensor_merge option=0");
  EXPECT_EQ(option(merge), "0");
  ASSERT_EQ(merge.buffers().size(), 2u);
  EXPECT_EQ(read_memories(merge.buffers()[1].get()), (std::vector<Bytes>{{5, 6, 7, 8}}));
  EXPECT_EQ(merge.error(), "");
}

}  // namespace tensor_merge_tuning_test
}  // namespace weir::test
