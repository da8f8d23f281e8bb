// The properties of tensor_filter that describe the model's tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_test_support.hpp"
#include "elements/tests/tuning_test_support.hpp"

namespace weir::test {
namespace declared_tensors_test {

std::string text(GstElement* element, const char* property) {
  gchar* raw = nullptr;
  g_object_get(element, property, &raw, nullptr);
  const gst::UniqueText owned{raw};
  return raw ? raw : "NULL";
}
constexpr const char* kAll[] = {"input",        "inputtype",  "inputname",  "inputlayout",
                                "inputranks",   "output",     "outputtype", "outputname",
                                "outputlayout", "outputranks"};

TEST(ReportedTensors, AreThoseOfTheModelInStateNull) {
  AdderFiles files;
  const auto filter = lone_element("tensor_filter framework=adder model=" + files.model(1));
  EXPECT_EQ(text(filter.get(), "input"), "4:1") << "1 for the open number of rows";
  EXPECT_EQ(text(filter.get(), "inputtype"), "float32");
  EXPECT_EQ(text(filter.get(), "inputlayout"), "ANY");
  EXPECT_EQ(text(filter.get(), "inputranks"), "2");
  EXPECT_EQ(text(filter.get(), "output"), "4:1");
  EXPECT_EQ(text(filter.get(), "outputtype"), "float32");
  EXPECT_EQ(GST_STATE(filter.get()), GST_STATE_NULL);
}

TEST(ReportedTensors, AreEmptyWithoutAModelThatOpens) {
  for (const char* line : {"tensor_filter", "tensor_filter framework=adder model=/nonexistent.add",
                           "tensor_filter framework=no_such_engine model=x"}) {
    const auto filter = lone_element(line);
    for (const char* property : kAll) EXPECT_EQ(text(filter.get(), property), "") << property;
  }
}

TEST(ReportedTensors, AreThoseThatTheUserSet) {
  AdderFiles files;
  const auto filter = lone_element(
      "tensor_filter framework=adder input=4:1 inputname=mine inputlayout=hwc,nchw "
      "outputlayout=nhwc model=" +
      files.model(1));
  EXPECT_EQ(text(filter.get(), "input"), "4:1");
  EXPECT_EQ(text(filter.get(), "inputname"), "mine");
  EXPECT_EQ(text(filter.get(), "inputlayout"), "NONE,NCHW") << "an unknown value is NONE";
  EXPECT_EQ(text(filter.get(), "outputlayout"), "NHWC");
}

// docs/compatibility/filter.md 4.1.
TEST(ReportedTensors, AreSpelledAsTheUserSpelledThem) {
  const auto filter = lone_element("tensor_filter input=3:4,5:1:1 output=1001:1:1:1");
  EXPECT_EQ(text(filter.get(), "inputranks"), "2,3");
  EXPECT_EQ(text(filter.get(), "outputranks"), "4");
  EXPECT_EQ(text(filter.get(), "inputname"), ",");
  EXPECT_EQ(text(filter.get(), "inputlayout"), "ANY,ANY");
  EXPECT_EQ(text(filter.get(), "outputname"), "");
  AdderFiles files;
  g_object_set(filter.get(), "framework", "adder", "model", files.model(1).c_str(), "input",
               "4:1:1", "output", "", nullptr);
  EXPECT_EQ(text(filter.get(), "inputranks"), "3");
  EXPECT_EQ(text(filter.get(), "outputranks"), "2");
}

TEST(ReportedTensors, AreThoseOfTheNegotiatedStream) {
  AdderFiles files;
  const auto model = files.write("open.bin", "x");
  Tuned t("tensor_filter", "tensor_filter framework=fake model=" + model,
          tensors("float32", "4:2"));
  EXPECT_EQ(t.get("input"), "4:2");
  EXPECT_EQ(t.get("output"), "4:2");
  EXPECT_EQ(t.get("outputtype"), "float32");
  EXPECT_EQ(t.get("inputranks"), "2");
  gst_harness_set_src_caps_str(t.harness.get(), tensors("float32", "4:3").c_str());
  EXPECT_EQ(t.get("input"), "4:3");
  gst_element_set_state(t.element.get(), GST_STATE_NULL);
  EXPECT_NE(t.get("input"), "4:3");
}

}  // namespace declared_tensors_test
}  // namespace weir::test
