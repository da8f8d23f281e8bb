// Tests of pipelines that are restricted to a list of elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <atomic>
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
class AddedElement : public PipelineAllowed {
 protected:
  void SetUp() override {
    ASSERT_EQ(refusal("fakesrc ! fakesink name=known", kFakes), "");
    // The API gives no access to elements; fakesink reveals itself with its first buffer.
    ASSERT_EQ(weir_pipeline_set(pipeline_, "known", "signal-handoffs", "true", nullptr), WEIR_OK);
    const guint signal = g_signal_lookup("preroll-handoff", g_type_from_name("GstFakeSink"));
    const gulong hook = g_signal_add_emission_hook(signal, 0, see, this, nullptr);
    ASSERT_EQ(weir_pipeline_start(pipeline_, nullptr), WEIR_OK);
    while (weir_pipeline_wait(pipeline_, 1000000, nullptr) == WEIR_PIPELINE_TIME_PASSED && !bin_)
      continue;
    g_signal_remove_emission_hook(signal, hook);
    ASSERT_TRUE(bin_);
  }
  void TearDown() override {
    if (bin_) gst_object_unref(bin_.load());
  }

  static gboolean see(GSignalInvocationHint*, guint, const GValue* values, gpointer test) {
    auto* seen = GST_OBJECT(g_value_get_object(values));
    GstObject* none = nullptr;
    auto* bin = gst_object_get_parent(seen);
    if (!static_cast<AddedElement*>(test)->bin_.compare_exchange_strong(none, bin))
      gst_object_unref(bin);
    return TRUE;
  }

  GstElement* add(const char* factory) {
    GstElement* element = gst_element_factory_make(factory, nullptr);
    gst_bin_add(GST_BIN(bin_.load()), element);
    return element;
  }

  std::atomic<GstObject*> bin_ = nullptr;
};

TEST_F(AddedElement, IsRejectedUnlessItIsListed) {
  add("fakesink");
  EXPECT_EQ(weir_pipeline_wait(pipeline_, 0, nullptr), WEIR_PIPELINE_TIME_PASSED);
  GstElement* added = add("identity");
  weir::CError error;
  const int result = weir_pipeline_wait(pipeline_, 0, error.place());
  EXPECT_EQ(result, -WEIR_OPTION_VALUE);
  EXPECT_SAYS(error.take(result).message(), "offered: identity");
  EXPECT_TRUE(gst_element_is_locked_state(added));
}

// A pipeline that is still starting may start the element before its signal is emitted.
TEST_F(AddedElement, IsStoppedIfItRunsAlready) {
  GstElement* added = gst_element_factory_make("identity", nullptr);
  gst_element_set_state(added, GST_STATE_PLAYING);
  gst_bin_add(GST_BIN(bin_.load()), added);
  EXPECT_EQ(GST_STATE(added), GST_STATE_NULL);
}

TEST_F(AddedElement, IsStoppedWithThePipelineIfItWasStartedLater) {
  GstElement* added = add("identity");
  gst_element_set_state(added, GST_STATE_PLAYING);
  EXPECT_EQ(weir_pipeline_stop(pipeline_, nullptr), WEIR_OK);
  EXPECT_EQ(GST_STATE(added), GST_STATE_NULL);
}

}  // namespace pipeline_allowed_test
