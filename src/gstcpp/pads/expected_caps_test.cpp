// ExpectedCaps: when the output caps are made, and from which caps of upstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/expected_caps.hpp"

#include <gtest/gtest.h>

#include <string>

namespace weir::gst {
namespace expected_caps_test {

class ExpectedCapsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    upstream_ = Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("src", GST_PAD_SRC))));
    sink_ = Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("sink", GST_PAD_SINK))));
    gst_pad_set_element_private(upstream_.get(), &offered_);
    gst_pad_set_query_function(upstream_.get(), handle_query);
    ASSERT_EQ(gst_pad_link(upstream_.get(), sink_.get()), GST_PAD_LINK_OK);
  }
  static gboolean handle_query(GstPad* pad, GstObject*, GstQuery* query) {
    const auto* text = static_cast<const std::string*>(gst_pad_get_element_private(pad));
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text->c_str()));
    gst_query_set_caps_result(query, caps.get());
    return TRUE;
  }
  // The output has the fields of the input under the name out/x.
  std::string query(const char* filter = nullptr) {
    const auto only = Ref<GstCaps>::adopt(filter ? gst_caps_from_string(filter) : nullptr);
    const auto caps = expected_.query(sink_.get(), only.get(), [this](GstCaps* input) {
      ++made_;
      if (!gst_caps_is_fixed(input)) return Ref<GstCaps>();
      auto out = Ref<GstCaps>::adopt(gst_caps_copy(input));
      gst_structure_set_name(gst_caps_get_structure(out.get(), 0), name_.c_str());
      return out;
    });
    return UniqueText(gst_caps_to_string(caps.get())).get();
  }

  Ref<GstPad> upstream_, sink_;
  std::string offered_ = "in/x, width=4", name_ = "out/x";
  ExpectedCaps expected_;
  int made_ = 0;
};

TEST_F(ExpectedCapsTest, AreMadeOnceForTheSameUpstreamCaps) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(query(), "out/x, width=(int)4");
  EXPECT_EQ(query("out/x, width=[1, 3]"), "EMPTY");
  EXPECT_EQ(made_, 1);
  offered_ = "in/x, width=4; in/x, width=5";
  for (int i = 0; i < 3; ++i) EXPECT_EQ(query("out/x, width=[5, 9]"), "out/x, width=(int)5");
  EXPECT_EQ(made_, 3);
}

TEST_F(ExpectedCapsTest, AreMadeAgainOnceForgotten) {
  EXPECT_EQ(query(), "out/x, width=(int)4");
  name_ = "out/y";
  EXPECT_EQ(query(), "out/x, width=(int)4");
  expected_.forget();
  EXPECT_EQ(query(), "out/y, width=(int)4");
  EXPECT_EQ(made_, 2);
}

TEST_F(ExpectedCapsTest, AreNoneWhereOneOutputIsNotKnown) {
  offered_ = "in/x, width=4; in/x, width=[1, 9]";
  EXPECT_EQ(query(), "EMPTY");
  EXPECT_EQ(query(), "EMPTY");
  EXPECT_EQ(made_, 2);
}

TEST_F(ExpectedCapsTest, AreOfAnOpenFramerateThoseOfNone) {
  offered_ = "in/x, framerate=[0/1, 60/1]";
  EXPECT_EQ(query(), "out/x, framerate=(fraction)0/1");
}

}  // namespace expected_caps_test
}  // namespace weir::gst
