// Tests of pipelines of GStreamer that a Pipeline adopts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include "pipeline_test_support.hpp"
#include "says.hpp"
#include "weir/pipeline.hpp"

namespace pipeline_adopted_test {

using namespace weir::pipeline_test;
using weir::Pipeline;
using weir::TensorShape;
using Values = std::vector<float>;

TEST(AdoptedPipeline, TakesFramesAndReturnsThem) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("appsrc name=in ! queue ! tensor_sink name=out", nullptr);
  ASSERT_TRUE(made);
  gst_object_ref(made);  // adopt() takes the floating reference
  {
    auto p = Pipeline::adopt(made);
    ASSERT_TRUE(p) << p.error().message();
    ASSERT_TRUE(p->start());
    const Values x{1, 2};
    ASSERT_TRUE(p->push("in", std::span<const float>(x), {.shape = {2}}));
    EXPECT_EQ(pulled(*p, "out"), x);
    EXPECT_REFUSED(Pipeline::adopt(made), OPTION_VALUE, "needed: a GstPipeline in the state NULL");
  }
  EXPECT_EQ(GST_STATE(made), GST_STATE_NULL);
  gst_object_unref(made);
}

TEST(AdoptedPipeline, HasOneOwnerAtATime) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("appsrc name=in ! tensor_sink name=out", nullptr);
  ASSERT_TRUE(made);
  gst_object_ref_sink(made);
  {
    const auto first = Pipeline::adopt(made);
    ASSERT_TRUE(first) << first.error().message();
    EXPECT_REFUSED(Pipeline::adopt(made), OPTION_VALUE, "this pipeline is adopted already");
  }
  const auto again = Pipeline::adopt(made);
  EXPECT_TRUE(again) << again.error().message();
  gst_object_unref(made);
}

TEST(AdoptedPipeline, IsNoBin) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* bin = gst_bin_new(nullptr);
  EXPECT_REFUSED(Pipeline::adopt(bin), OPTION_VALUE,
                 "fix: GstElement *pipeline = gst_pipeline_new");
  EXPECT_TRUE(g_object_is_floating(bin));
  gst_object_unref(gst_object_ref_sink(bin));
}

// The program may hold pointers to its elements.
TEST(AdoptedPipeline, KeepsItsElements) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("appsrc name=in ! tensor_sink name=out", nullptr);
  ASSERT_TRUE(made);
  GstElement* source = gst_bin_get_by_name(GST_BIN(made), "in");
  {
    auto p = Pipeline::adopt(made);
    ASSERT_TRUE(p) << p.error().message();
    const Values x{1, 2, 3, 4};
    for (const TensorShape& shape : {TensorShape{4}, TensorShape{4}, TensorShape{2, 2}}) {
      ASSERT_TRUE(p->start());
      ASSERT_TRUE(p->push("in", std::span<const float>(x), {.shape = shape}));
      const auto frame = p->pull<float>("out", kLong);
      ASSERT_TRUE(frame && *frame);
      EXPECT_EQ((**frame)[0].info().shape, shape);
      ASSERT_TRUE(p->stop());
      EXPECT_EQ(GST_OBJECT_PARENT(source), GST_OBJECT(made));
    }
  }
  gst_object_unref(source);
}

}  // namespace pipeline_adopted_test
