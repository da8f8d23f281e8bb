// tensor_demux whose tensorpick changes while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/branches_test_support.hpp"

namespace weir::test {
namespace tensor_demux_tuning_test {

constexpr char kThree[] =
    "other/tensors,format=static,num_tensors=3,dimensions=(string)\"1,1,1\","
    "types=(string)\"uint8,uint8,uint8\",framerate=30/1";

std::string picked(const Branches& demux) {
  gchar* raw = nullptr;
  g_object_get(demux.element(), "tensorpick", &raw, nullptr);
  const UniqueText text{raw};
  return text.get();
}

TEST(DemuxPropertyChange, NewPickAppliesToTheNextFrame) {
  Branches demux("tensor_demux tensorpick=0");
  demux.caps(kThree);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{7});
  g_object_set(demux.element(), "tensorpick", "2,1:0", nullptr);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{9});
  const auto both = demux.take("src_1");
  EXPECT_EQ(content(both.get(), 0), Bytes{8});
  EXPECT_EQ(content(both.get(), 1), Bytes{7});
  EXPECT_SAYS(demux.branch("src_1").caps(), "num_tensors=(int)2");
  g_object_set(demux.element(), "tensorpick", "1", nullptr);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{8});
  EXPECT_TRUE(demux.branch("src_1").buffers.empty());
  demux.expect_balance();
}

TEST(DemuxPropertyChange, InvalidPickIsRejectedAndRestored) {
  Branches demux("tensor_demux tensorpick=0");
  demux.caps(kThree);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  demux.take("src_0");
  g_object_set(demux.element(), "tensorpick", "x", nullptr);
  EXPECT_EQ(picked(demux), "0");
  EXPECT_SAYS(demux.warning(), "WEIR-1");
  g_object_set(demux.element(), "tensorpick", "3", nullptr);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  EXPECT_SAYS(demux.warning(), "tensorpick");
  EXPECT_EQ(picked(demux), "0");
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{7});
}

TEST(DemuxPropertyChange, OutputThatDownstreamRejectsIsRejected) {
  Branches demux("tensor_demux tensorpick=0",
                 {{"src_0", "other/tensors,format=static,num_tensors=1"}});
  demux.caps(kThree);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  demux.take("src_0");
  g_object_set(demux.element(), "tensorpick", "1:2", nullptr);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  EXPECT_SAYS(demux.warning(),
              "WEIR-2001: the element downstream of src_0 does not accept its output");
  EXPECT_EQ(picked(demux), "0");
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{7});
  EXPECT_EQ(demux.error(), "");
  g_object_set(demux.element(), "tensorpick", "2,0:1", nullptr);
  ASSERT_EQ(demux.push(make_frame({{7}, {8}, {9}})), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{9});
  EXPECT_EQ(demux.warning(), "");
}

}  // namespace tensor_demux_tuning_test
}  // namespace weir::test
