// tensor_split whose segments change while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/branches_test_support.hpp"

namespace weir::test {
namespace tensor_split_tuning_test {

std::string read(const Branches& split, const char* property) {
  gchar* raw = nullptr;
  g_object_get(split.element(), property, &raw, nullptr);
  const UniqueText text{raw};
  return text.get();
}

TEST(SplitPropertyChange, NewSegmentsApplyToTheNextFrame) {
  Branches split("tensor_split tensorseg=1,3");
  split.caps(test::tensors("uint8", "4"));
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), Bytes{1});
  EXPECT_EQ(content(split.take("src_1").get(), 0), (Bytes{2, 3, 4}));
  g_object_set(split.element(), "tensorseg", "2,2", nullptr);
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), (Bytes{1, 2}));
  EXPECT_EQ(content(split.take("src_1").get(), 0), (Bytes{3, 4}));
  EXPECT_SAYS(split.branch("src_0").caps(), "dimensions=(string)2");
  g_object_set(split.element(), "tensorpick", "1", nullptr);
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), (Bytes{3, 4}));
  EXPECT_TRUE(split.branch("src_1").buffers.empty());
}

TEST(SplitPropertyChange, InvalidSegmentsAreRejectedAndRestored) {
  Branches split("tensor_split tensorseg=1,3");
  split.caps(test::tensors("uint8", "4"));
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  split.take("src_0");
  g_object_set(split.element(), "tensorseg", "a:b", nullptr);
  EXPECT_EQ(read(split, "tensorseg"), "1,3");
  EXPECT_SAYS(split.warning(), "WEIR-1");
  g_object_set(split.element(), "tensorseg", "3,3", nullptr);
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_SAYS(split.warning(), "WEIR-");
  EXPECT_EQ(read(split, "tensorseg"), "1,3");
  EXPECT_EQ(content(split.take("src_0").get(), 0), Bytes{1});
}

TEST(SplitPropertyChange, PropertiesFixedWhilePlayingAreRejectedWithAWarning) {
  Branches split("tensor_split tensorseg=1,3");
  g_object_set(split.element(), "split-dim", 0, nullptr);
  int dimension = 9;
  g_object_get(split.element(), "split-dim", &dimension, nullptr);
  EXPECT_EQ(dimension, -1);
  const auto text = split.warning();
  EXPECT_SAYS(text, "WEIR-1004: the property split-dim cannot change while the element runs");
  EXPECT_SAYS(text, "offered: split-dim=0");
  EXPECT_SAYS(text, "gst_element_set_state (element, GST_STATE_READY)");
  g_object_set(split.element(), "split-dim", -1, nullptr);
  EXPECT_EQ(split.warning(), "") << "the current value";
  g_object_set(split.element(), "silent", FALSE, nullptr);
  EXPECT_EQ(split.warning(), "");
}

TEST(SplitPropertyChange, ASecondWriteCompletesTheFirst) {
  Branches split("tensor_split tensorseg=1,3 tensorpick=1");
  split.caps(test::tensors("uint8", "4"));
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), (Bytes{2, 3, 4}));
  g_object_set(split.element(), "tensorseg", "4", nullptr);
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), (Bytes{2, 3, 4}));
  EXPECT_SAYS(split.warning(), "tensorpick names a segment that does not exist");
  EXPECT_EQ(read(split, "tensorseg"), "1,3");
  g_object_set(split.element(), "tensorpick", "0", nullptr);
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(read(split, "tensorseg"), "4");
  EXPECT_EQ(read(split, "tensorpick"), "0");
  EXPECT_EQ(split.warning(), "");
}

TEST(SplitPropertyChange, OutputThatDownstreamRejectsIsRejected) {
  Branches split("tensor_split tensorseg=1,3",
                 {{"src_1", "other/tensors,format=static,num_tensors=1,dimensions=(string)3"}});
  split.caps(test::tensors("uint8", "4"));
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  split.take("src_1");
  g_object_set(split.element(), "tensorseg", "2,2", nullptr);
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_SAYS(split.warning(),
              "WEIR-2001: the element downstream of src_1 does not accept its output");
  EXPECT_EQ(read(split, "tensorseg"), "1,3");
  EXPECT_EQ(content(split.take("src_1").get(), 0), (Bytes{2, 3, 4}));
  EXPECT_EQ(split.error(), "");
}

}  // namespace tensor_split_tuning_test
}  // namespace weir::test
