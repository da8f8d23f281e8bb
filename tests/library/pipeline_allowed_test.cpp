// Tests of pipelines that are restricted to a list of elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <vector>

#include "says.hpp"
#include "weir/c_error.hpp"
#include "weir/pipeline.h"

namespace pipeline_allowed_test {

// An element with a property "inner" of type element, like playbin's video-sink.
struct Holder {
  GstElement parent;
};
struct HolderClass {
  GstElementClass parent;
};
int holders_made = 0;

// Takes the element with its floating reference and releases it.
void set_inner(GObject*, guint, const GValue* value, GParamSpec*) {
  gst_object_unref(gst_object_ref_sink(g_value_get_object(value)));
}

GType holder_type() {
  static const GType type = g_type_register_static_simple(
      GST_TYPE_ELEMENT, "WeirTestHolder", sizeof(HolderClass),
      [](gpointer type_class, gpointer) {
        auto* object = G_OBJECT_CLASS(type_class);
        object->set_property = set_inner;
        g_object_class_install_property(
            object, 1,
            g_param_spec_object("inner", "inner", "inner", GST_TYPE_ELEMENT, G_PARAM_WRITABLE));
        gst_element_class_set_static_metadata(GST_ELEMENT_CLASS(type_class), "holder", "Test",
                                              "holds an element", "Weir");
      },
      sizeof(Holder), [](GTypeInstance*, gpointer) { ++holders_made; }, GTypeFlags(0));
  return type;
}

class PipelineAllowed : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    gst_init(nullptr, nullptr);
    gst_element_register(nullptr, "testholder", GST_RANK_NONE, holder_type());
  }
  ~PipelineAllowed() override { weir_pipeline_free(pipeline_); }

  // "" when the description is allowed; otherwise the reason.
  std::string refusal(const char* text, std::vector<const char*> allowed) {
    weir_pipeline_free(pipeline_);
    weir::CError error;
    const int result = weir_pipeline_parse_allowed(
        text, allowed.data(), static_cast<uint32_t>(allowed.size()), &pipeline_, error.place());
    if (result == WEIR_OK) return "";
    EXPECT_EQ(pipeline_, nullptr);
    const std::string why = error.take(-WEIR_OPTION_VALUE).message();
    return (result == 1 ? "forbidden: " : "error: ") + why;
  }
  weir_pipeline* pipeline_ = nullptr;
};

const std::vector<const char*> kFakes{"fakesrc", "fakesink", "testholder"};

TEST_F(PipelineAllowed, IsBuiltFromTheListedElements) {
  for (const char* text :
       {"fakesrc ! fakesink", "fakesrc ! video/x-raw,format=RGB ! fakesink",
        "fakesrc name=filesink", "( fakesrc name=a ! fakesink )", "bin.( fakesrc ! fakesink )",
        "pipeline.( fakesrc ! fakesink )", "fakesrc name=a a. ! fakesink",
        "testholder inner=\"fakesrc ! fakesink\""})
    EXPECT_EQ(refusal(text, kFakes), "") << text;
}

TEST_F(PipelineAllowed, RejectsEveryOtherElement) {
  for (const char* text :
       {"filesrc ! fakesink", "fakesrc!filesink location=/x", "( fakesrc ! filesink )",
        "( fakesrc name=x ! fakesink name=y ) ( filesrc name=x ! filesink name=y )",
        "filesink.( fakesrc )", "fakesrc name=\"a b\"filesink", "fakesrc ! FakeSink",
        "testholder inner=filesink", "testholder inner=\"fakesrc ! filesink location=\\\"/x\\\"\"",
        "testholder inner=\"testholder inner=filesink\"", "testholder inner::sink=filesink",
        "file:///etc/hostname ! fakesink", "fakesrc ! FILE:///tmp/x"}) {
    const std::string why = refusal(text, kFakes);
    EXPECT_SAYS(why, "forbidden: WEIR-1004: the configuration does not allow this element") << text;
    EXPECT_SAYS(why, "needed: one of: fakesrc, fakesink, testholder") << text;
  }
  EXPECT_SAYS(refusal("fakesrc ! filesink", {"fakesrc"}), "offered: filesink");
  EXPECT_SAYS(refusal("fakesrc", {}), "needed: one of: none");
}

TEST_F(PipelineAllowed, CreatesNothingBeforeTheCheck) {
  const int before = holders_made;
  EXPECT_NE(refusal("testholder ! filesink", kFakes), "");
  EXPECT_NE(refusal("testholder inner=filesink", kFakes), "");
  EXPECT_EQ(holders_made, before);
}

TEST_F(PipelineAllowed, ReportsOtherErrors) {
  EXPECT_SAYS(refusal("fakesrc ! ! fakesink", kFakes),
              "error: WEIR-1004: the pipeline description cannot be parsed: syntax error");
  EXPECT_SAYS(refusal("fakesrc nosuch=1", kFakes), "nosuch");
}

// Like decodebin, which adds elements while the pipeline plays.
TEST_F(PipelineAllowed, RejectsAnElementThatIsAddedLater) {
  ASSERT_EQ(refusal("fakesrc ! fakesink name=known", kFakes), "");
  static GstElement* seen = nullptr;
  const auto see = [](GSignalInvocationHint*, guint, const GValue* values, gpointer) -> gboolean {
    seen = GST_ELEMENT(g_value_get_object(values));
    return FALSE;
  };
  // The API gives no access to elements; fakesink reveals itself with its first buffer.
  ASSERT_EQ(weir_pipeline_set(pipeline_, "known", "signal-handoffs", "true", nullptr), WEIR_OK);
  const GType type = g_type_from_name("GstFakeSink");
  g_signal_add_emission_hook(g_signal_lookup("preroll-handoff", type), 0, see, nullptr, nullptr);
  ASSERT_EQ(weir_pipeline_start(pipeline_, nullptr), WEIR_OK);
  while (weir_pipeline_wait(pipeline_, 1000000, nullptr) == WEIR_PIPELINE_TIME_PASSED && !seen)
    continue;
  ASSERT_NE(seen, nullptr);
  auto* bin = GST_BIN(gst_object_get_parent(GST_OBJECT(seen)));
  gst_bin_add(bin, gst_element_factory_make("fakesink", nullptr));
  EXPECT_EQ(weir_pipeline_wait(pipeline_, 0, nullptr), WEIR_PIPELINE_TIME_PASSED);
  GstElement* added = gst_element_factory_make("identity", nullptr);
  gst_bin_add(bin, added);
  weir::CError error;
  const int result = weir_pipeline_wait(pipeline_, 0, error.place());
  EXPECT_EQ(result, -WEIR_OPTION_VALUE);
  EXPECT_SAYS(error.take(result).message(), "offered: identity");
  EXPECT_TRUE(gst_element_is_locked_state(added));
  gst_object_unref(bin);
}

}  // namespace pipeline_allowed_test
