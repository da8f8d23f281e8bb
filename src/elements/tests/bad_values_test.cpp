// Every enum property of every element: an invalid value is rejected with an error that lists the
// valid ones, and each valid one is accepted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "elements/tests/element_parts_test_support.hpp"
#include "gstcpp/element/property_text.hpp"
#include "gstcpp/element/ref.hpp"
#include "says.hpp"
#include "weir/join.hpp"

namespace weir::gst {
namespace bad_values_test {

// The error and the element of gst_parse_launch().
struct Parsed {
  explicit Parsed(const std::string& text) {
    GError* raw = nullptr;
    GstElement* made = gst_parse_launch_full(text.c_str(), nullptr, GST_PARSE_FLAG_NONE, &raw);
    if (made) gst_object_ref_sink(made);
    read = Ref<GstElement>::adopt(made);
    error.reset(raw);
  }
  std::string error_text() const {
    if (!error) return "";
    const auto found = refused_property(*error);
    return found ? found->error.message() : std::string("of another kind: ") + error->message;
  }
  Ref<GstElement> read;
  Unique<GError, g_error_free> error;
};

// Maps "tensor_preprocess layout=" to its values.
std::map<std::string, std::vector<std::string>> values_by_property() {
  std::map<std::string, std::vector<std::string>> out;
  for (const auto& name : test::element_names()) {
    const Parsed element(name);
    if (!element.read) continue;
    guint count = 0;
    const Unique<GParamSpec*, g_free> all(
        g_object_class_list_properties(G_OBJECT_GET_CLASS(element.read.get()), &count));
    for (guint i = 0; i < count; ++i) {
      GParamSpec* spec = all.get()[i];
      if (!(spec->flags & G_PARAM_WRITABLE) || !G_TYPE_IS_ENUM(spec->value_type)) continue;
      auto& values = out[name + " " + spec->name + "="];
      const auto* type = G_PARAM_SPEC_ENUM(spec)->enum_class;
      for (guint w = 0; w < type->n_values; ++w) values.emplace_back(type->values[w].value_nick);
    }
  }
  return out;
}

TEST(BadValues, ErrorsListTheValuesOfEachProperty) {
  const auto all = values_by_property();
  EXPECT_GE(all.size(), 20u);
  EXPECT_TRUE(all.contains("tensor_preprocess layout="));
  EXPECT_TRUE(all.contains("tensor_transform mode="));
  for (const auto& [assignment, values] : all) {
    const std::string needed = join(values, ", ");
    const std::string message = Parsed(assignment + "nonsense").error_text();
    EXPECT_SAYS(message, "WEIR-1004: " + assignment.substr(0, assignment.find(' ')) +
                             " does not accept this value for ");
    EXPECT_SAYS(message, "offered: nonsense\n  needed: one of: " + needed + "\n");
  }
}

TEST(BadValues, EachListedValueIsAccepted) {
  for (const auto& [assignment, values] : values_by_property())
    for (const auto& value : values)
      EXPECT_EQ(Parsed(assignment + "\"" + value + "\"").error_text(), "") << assignment << value;
}

TEST(BadValues, TheNearestValueIsSuggested) {
  EXPECT_SAYS(Parsed("fakesrc ! tensor_preprocess method=bilnear ! fakesink").error_text(),
              "did you mean bilinear?\n  fix: gst-inspect-1.0 tensor_preprocess");
  EXPECT_SAYS(Parsed("tensor_preprocess layout=NHCW").error_text(), "did you mean NHWC?");
  EXPECT_SAYS(Parsed("tensor_preprocess channel-order=rgb").error_text(), "did you mean RGB?");
}

TEST(BadValues, ErrorsExplainHowFlagsAreJoined) {
  EXPECT_SAYS(Parsed("tensor_debug output-method=console-inf").error_text(),
              "did you mean console-info?");
  EXPECT_SAYS(Parsed("tensor_debug output-method=console-inf").error_text(),
              "circularbuf, filewrite; join several with +");
  EXPECT_EQ(Parsed("tensor_debug output-method=console-info+circularbuf").error_text(), "");
}

TEST(BadValues, ErrorsNameTheTypeOfOtherProperties) {
  EXPECT_SAYS(Parsed("tensor_sink sync=perhaps").error_text(), "needed: true or false");
  EXPECT_SAYS(Parsed("tensor_preprocess width=many").error_text(),
              "needed: a whole number from 0 to 65536");
  EXPECT_SAYS(Parsed("tensor_preprocess layuot=NHWC").error_text(),
              "WEIR-1004: tensor_preprocess has no such property\n  offered: layuot");
  EXPECT_SAYS(Parsed("tensor_preprocess layuot=NHWC").error_text(), "did you mean layout?");
}

TEST(BadValues, OtherParserErrorsAreIgnored) {
  EXPECT_SAYS(Parsed("fakesrc ! tensor_preproces ! fakesink").error_text(), "of another kind: ");
  EXPECT_SAYS(Parsed("fakesrc ! ! fakesink").error_text(), "of another kind: ");
}

}  // namespace bad_values_test
}  // namespace weir::gst
