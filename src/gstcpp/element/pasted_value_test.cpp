// Tries the quotes for values in pipeline descriptions with GStreamer's parser.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/text/shell_quote.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace pasted_value_test {

std::string property(GstElement* element, const char* name) {
  char* text = nullptr;
  g_object_get(element, name, &text, nullptr);
  const gst::UniqueText owned(text);
  return text ? text : "(none)";
}

// Two properties of one element that a line for the shell sets, and no further element.
void expect_read(const std::string& first, const std::string& second) {
  const std::string line =
      "tensor_decoder name=d mode=octet_stream option1=" + launch_value(first) +
      " option2=" + launch_value(second) + " ! fakesink name=\"end\"";
  char** words = nullptr;
  ASSERT_TRUE(g_shell_parse_argv(line.c_str(), nullptr, &words, nullptr)) << line;
  const gst::Unique<char*, g_strfreev> owned(words);
  GError* error = nullptr;
  GstElement* parsed = gst_parse_launchv(const_cast<const char**>(words), &error);
  ASSERT_EQ(error, nullptr) << line << "\n" << error->message;
  const auto pipeline = gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(parsed)));
  EXPECT_EQ(GST_BIN_NUMCHILDREN(pipeline.get()), 2) << line;
  const auto decoder =
      gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "d"));
  ASSERT_TRUE(decoder) << line;
  EXPECT_EQ(property(decoder.get(), "option1"), first) << line;
  EXPECT_EQ(property(decoder.get(), "option2"), second) << line;
}

TEST(PastedValue, IsReadAsTheTextByGStreamer) {
  for (const std::string text : {"plain",
                                 "",
                                 "a b",
                                 "a\\",
                                 "\\",
                                 "\\\\",
                                 "\"",
                                 "\"a\"",
                                 "a\"",
                                 "\"a\" b\\",
                                 "'",
                                 "it's",
                                 "NULL",
                                 "a\nb\\",
                                 "\n",
                                 " a ",
                                 "x ! fakesink",
                                 "$HOME",
                                 "`id`",
                                 "a=b",
                                 "(string)a",
                                 "caf\xc3\xa9",
                                 "\xc3\xa9\\",
                                 "\x1b[2J",
                                 "\\\" ! fakesink \"",
                                 "d.",
                                 "#",
                                 "%5C"})
    for (const std::string other : {"x", "\"y z\"", "\\", text.c_str()}) expect_read(text, other);
}

// GStreamer has no text for such a property: an error, and no other pipeline.
TEST(PastedValue, ThatIsNotUtf8IsRefused) {
  for (const std::string text :
       {"\xff\xfe", "\xed\xa0\x80", "a\xc3", "\xc0\x80 ! fakesink", "\x80\""}) {
    const std::string line = "tensor_decoder option1=" + launch_value(text) + " ! fakesink";
    char** words = nullptr;
    ASSERT_TRUE(g_shell_parse_argv(line.c_str(), nullptr, &words, nullptr)) << line;
    const gst::Unique<char*, g_strfreev> owned(words);
    GError* raw = nullptr;
    GstElement* parsed = gst_parse_launchv_full(const_cast<const char**>(words), nullptr,
                                                GST_PARSE_FLAG_FATAL_ERRORS, &raw);
    const gst::Unique<GError, g_error_free> error(raw);
    EXPECT_EQ(parsed, nullptr) << line;
    ASSERT_NE(error, nullptr) << line;
    EXPECT_TRUE(
        g_error_matches(error.get(), GST_PARSE_ERROR, GST_PARSE_ERROR_COULD_NOT_SET_PROPERTY))
        << error->message;
  }
}

TEST(PastedValue, OfRandomTextIsReadAsTheText) {
  constexpr std::string_view kSpecial = "\"\\'!$`;=(){}<>,.: \n\t\r#";
  std::mt19937 random(7);
  const auto text = [&random, kSpecial] {
    std::string out;
    for (size_t n = random() % 12; n > 0; --n) switch (random() % 5) {
        case 0:
          out += static_cast<char>(1 + random() % 127);
          break;
        case 1:
          out += random() % 2 ? "\xc3\xa9" : "\xe2\x80\xa8";
          break;
        default:
          out += kSpecial[random() % kSpecial.size()];
      }
    return out;
  };
  for (int i = 0; i < 500 && !testing::Test::HasFailure(); ++i) expect_read(text(), text());
}

}  // namespace pasted_value_test
}  // namespace weir
