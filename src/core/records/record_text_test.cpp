// Tests of numbers, times and strings in the text formats of results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/record_text.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

namespace weir::records {
namespace record_text_test {

template <class Append, class Value>
std::string text(Append append, Value value) {
  std::string out;
  append(value, &out);
  return out;
}
std::string number(float value) {
  return text([](float v, std::string* out) { append_number(v, out); }, value);
}

TEST(RecordText, NumbersAreShortAndReadBackTheSame) {
  EXPECT_EQ(number(0.1f), "0.1");
  EXPECT_EQ(number(-0.0f), "0");
  EXPECT_EQ(number(1280), "1280");
  EXPECT_EQ(number(123.456f), "123.456");
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    const uint32_t bits = random();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(nlohmann::json::parse(number(value)).get<float>(), value) << number(value);
  }
}

TEST(RecordText, NumbersIgnoreTheLocale) {
  const char* before = std::setlocale(LC_NUMERIC, nullptr);
  const std::string restored = before ? before : "C";
  const bool has_comma = std::setlocale(LC_NUMERIC, "de_DE.UTF-8") != nullptr;
  EXPECT_EQ(number(0.5f), "0.5");
  EXPECT_EQ(text(append_seconds, 1500000000), "1.5");
  std::setlocale(LC_NUMERIC, restored.c_str());
  if (!has_comma) GTEST_SKIP() << "no locale with a decimal comma is installed";
}

TEST(RecordText, SecondsHaveTheDecimalsThatTheyNeed) {
  EXPECT_EQ(text(append_seconds, 0), "0");
  EXPECT_EQ(text(append_seconds, 40000000), "0.04");
  EXPECT_EQ(text(append_seconds, 12000000001), "12.000000001");
  EXPECT_EQ(text(append_seconds, -500000000), "-0.5");
  EXPECT_EQ(text(append_seconds, std::numeric_limits<int64_t>::max()), "9223372036.854775807");
}

TEST(RecordText, UtcIsThatOfTheCalendar) {
  // date -u -d @1709208000 says 2024-02-29 12:00:00.
  EXPECT_EQ(text(append_utc, 1709208000500000000), "2024-02-29T12:00:00.5Z");
  EXPECT_EQ(text(append_utc, 0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(text(append_utc, 1), "1970-01-01T00:00:00.000000001Z");
}

TEST(RecordText, StringsAreJsonWhateverTheBytes) {
  EXPECT_EQ(text(append_json_string, "a\"b\\c\n\x01\x7F/"), "\"a\\\"b\\\\c\\n\\u0001\\u007f/\"");
  // C1 and a change of direction, which terminals act on.
  EXPECT_EQ(text(append_json_string, "\xC2\x9B\xE2\x80\xAE\xC2\xA0"), "\"\\u009b\\u202e\xC2\xA0\"");
  EXPECT_EQ(text(append_json_string, "Gr\xC3\xBC\xC3\x9F"), "\"Gr\xC3\xBC\xC3\x9F\"");
  // A lone continuation, a surrogate, a cut sequence.
  EXPECT_EQ(nlohmann::json::parse(text(append_json_string, "a\x80z\xED\xA0\x80\xE2\x82")),
            "a\xEF\xBF\xBDz\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
  std::string all;
  for (int c = 0; c < 256; ++c) all.push_back(static_cast<char>(c));
  EXPECT_TRUE(nlohmann::json::accept(text(append_json_string, all)));
}

}  // namespace record_text_test
}  // namespace weir::records
