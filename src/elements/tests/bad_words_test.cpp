// Every property of every element whose values are words: a word that is none of them is refused
// with all of them, and each of them is taken.
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "elements/tests/element_parts.hpp"
#include "gstcpp/property_text.hpp"
#include "gstcpp/ref.hpp"
#include "says.hpp"

namespace weir::gst {
namespace {

// What gst_parse_launch says and made.
struct Parsed {
  explicit Parsed(const std::string& text) {
    GError* raw = nullptr;
    GstElement* made = gst_parse_launch_full(text.c_str(), nullptr, GST_PARSE_FLAG_NONE, &raw);
    if (made) gst_object_ref_sink(made);
    read = Ref<GstElement>::adopt(made);
    error.reset(raw);
  }
  std::string refused() const {
    if (!error) return "";
    const auto found = refused_property(*error);
    return found ? found->error.message() : std::string("of another kind: ") + error->message;
  }
  Ref<GstElement> read;
  Unique<GError, g_error_free> error;
};

// "tensor_preprocess layout=" to its words.
std::map<std::string, std::vector<std::string>> properties_of_words() {
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
      auto& words = out[name + " " + spec->name + "="];
      const auto* type = G_PARAM_SPEC_ENUM(spec)->enum_class;
      for (guint w = 0; w < type->n_values; ++w) words.emplace_back(type->values[w].value_nick);
    }
  }
  return out;
}

TEST(BadWords, EachElementListsTheWordsOfEachProperty) {
  const auto all = properties_of_words();
  EXPECT_GE(all.size(), 20u);
  EXPECT_TRUE(all.contains("tensor_preprocess layout="));
  EXPECT_TRUE(all.contains("tensor_transform mode="));
  for (const auto& [assignment, words] : all) {
    std::string needed;
    for (const auto& word : words) needed += (needed.empty() ? "" : ", ") + word;
    const std::string said = Parsed(assignment + "nonsense").refused();
    EXPECT_SAYS(said, "WEIR-1004: " + assignment.substr(0, assignment.find(' ')) +
                          " does not take this value for ");
    EXPECT_SAYS(said, "offered: nonsense\n  needed: one of: " + needed + "\n");
  }
}

TEST(BadWords, EachWordThatIsListedIsTaken) {
  for (const auto& [assignment, words] : properties_of_words())
    for (const auto& word : words)
      EXPECT_EQ(Parsed(assignment + "\"" + word + "\"").refused(), "") << assignment << word;
}

TEST(BadWords, TheNearestWordIsGuessed) {
  EXPECT_SAYS(Parsed("fakesrc ! tensor_preprocess method=bilnear ! fakesink").refused(),
              "did you mean bilinear?\n  fix: gst-inspect-1.0 tensor_preprocess");
  EXPECT_SAYS(Parsed("tensor_preprocess layout=NHCW").refused(), "did you mean NHWC?");
  EXPECT_SAYS(Parsed("tensor_preprocess channel-order=rgb").refused(), "did you mean RGB?");
}

TEST(BadWords, FlagsSayThatTheyAreJoined) {
  EXPECT_SAYS(Parsed("tensor_debug output-method=console-inf").refused(),
              "did you mean console-info?");
  EXPECT_SAYS(Parsed("tensor_debug output-method=console-inf").refused(),
              "circularbuf, filewrite; several with + between");
  EXPECT_EQ(Parsed("tensor_debug output-method=console-info+circularbuf").refused(), "");
}

TEST(BadWords, OtherPropertiesSayWhatTheyTake) {
  EXPECT_SAYS(Parsed("tensor_sink sync=perhaps").refused(), "needed: true or false");
  EXPECT_SAYS(Parsed("tensor_preprocess width=many").refused(), "needed: a guint");
  EXPECT_SAYS(Parsed("tensor_preprocess layuot=NHWC").refused(),
              "WEIR-1004: tensor_preprocess has no such property\n  offered: layuot");
  EXPECT_SAYS(Parsed("tensor_preprocess layuot=NHWC").refused(), "did you mean layout?");
}

TEST(BadWords, OtherErrorsOfTheParserAreNotTaken) {
  EXPECT_SAYS(Parsed("fakesrc ! tensor_preproces ! fakesink").refused(), "of another kind: ");
  EXPECT_SAYS(Parsed("fakesrc ! ! fakesink").refused(), "of another kind: ");
}

}  // namespace
}  // namespace weir::gst
