// Parses the properties of tensor_if.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/condition.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::condition {
namespace condition_test {

TEST(SuppliedValue, IsWholeOrReal) {
  const auto whole = *parse_supplied_value(" -3 , 9223372036854775807 ");
  ASSERT_EQ(whole.size(), 2u);
  EXPECT_FALSE(whole[0].is_real);
  EXPECT_EQ(whole[0].whole, -3);
  EXPECT_EQ(whole[1].whole, INT64_MAX);
  EXPECT_EQ((*parse_supplied_value("+7"))[0].whole, 7);
  for (const char* text : {"1.5", "15e-1", "1.5E0", "+1.5"}) {
    const auto real = *parse_supplied_value(text);
    ASSERT_EQ(real.size(), 1u);
    EXPECT_TRUE(real[0].is_real);
    EXPECT_EQ(real[0].real, 1.5);
  }
  const auto mixed = *parse_supplied_value("1,2.5");
  EXPECT_TRUE(mixed[0].is_real) << "one real number makes both real";
  EXPECT_EQ(mixed[0].real, 1);
  EXPECT_TRUE(parse_supplied_value("")->empty());
}

std::string value_error(const char* text) {
  const auto value = parse_supplied_value(text);
  EXPECT_FALSE(value) << text;
  return value ? "" : value.error().message();
}

TEST(SuppliedValue, ShowsThePlaceOfATypo) {
  EXPECT_SAYS(value_error("10,1OO"), "WEIR-1001: supplied-value cannot be read");
  EXPECT_SAYS(value_error("10,1OO"), "at character 4:\n    10,1OO\n       ^");
  EXPECT_SAYS(value_error("1,2,3"), "at character 5:");
  EXPECT_SAYS(value_error("1,"), "at the end:");
  EXPECT_SAYS(value_error("1:2"), "at character 1:");
  EXPECT_SAYS(value_error("9223372036854775808"), "integers must fit into int64");
  EXPECT_SAYS(value_error("1.5.2"), "at character 1:");
  EXPECT_SAYS(value_error("1e999"), "at character 1:");
  EXPECT_SAYS(value_error("e"), "at character 1:");
}

TEST(ElementPlace, IsCoordinateAndTensor) {
  const auto place = parse_element_place(" 1 : 2:3 , 4 ");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->coordinate[0], 1u);
  EXPECT_EQ(place->coordinate[2], 3u);
  EXPECT_EQ(place->coordinate[3], 0u) << "missing ones are 0";
  EXPECT_EQ(place->tensor, 4u);
  EXPECT_EQ(parse_element_place(",1")->tensor, 1u);
  EXPECT_EQ(parse_element_place("0:0:0:0:0:0:0:0:0:0:0:0:0:0:0:7,0")->coordinate[15], 7u);
}

TEST(ElementPlace, ShowsThePlaceOfATypo) {
  const auto at = [](const char* text) {
    const auto place = parse_element_place(text);
    EXPECT_FALSE(place) << text;
    return place ? std::string() : place.error().message();
  };
  EXPECT_SAYS(at("1:x,0"), "WEIR-1001: compared-value-option cannot be read");
  EXPECT_SAYS(at("1:x,0"), "at character 3:\n    1:x,0\n      ^");
  EXPECT_SAYS(at("1:2"), "at the end:");
  EXPECT_SAYS(at("1:2,"), "at the end:");
  EXPECT_SAYS(at("1,2,3"), "at character 5:");
  EXPECT_SAYS(at("1:,0"), "at character 3:");
  EXPECT_SAYS(at("-1,0"), "at character 1:");
  EXPECT_SAYS(at("0:0:0:0:0:0:0:0:0:0:0:0:0:0:0:0:0,0"), "at character 33:");
}

TEST(Condition, ReadsTheOptionForItsKind) {
  const auto average = parse_condition(ComparedValue::Average, " 2 ", Operator::Less, "5");
  ASSERT_TRUE(average);
  EXPECT_EQ(average->place->tensor, 2u);
  EXPECT_EQ(parse_condition(ComparedValue::Custom, "mine", Operator::Less, "")->callback, "mine");
  EXPECT_SAYS(parse_condition(ComparedValue::Average, "0,1", Operator::Less, "5").error().message(),
              "at character 1:\n    0,1");
  EXPECT_FALSE(parse_condition(ComparedValue::Element, "0,0", Operator::Less, "five"));
}

TEST(Condition, ReportsWhatIsMissing) {
  const auto error_text = [](ComparedValue compared, const char* option, Operator op,
                             const char* value) {
    const auto error = missing(*parse_condition(compared, option, op, value));
    return error ? error->message() : std::string();
  };
  EXPECT_SAYS(error_text(ComparedValue::Element, "", Operator::Equal, "1"),
              "WEIR-1004: tensor_if needs to know what to compare\n");
  EXPECT_SAYS(error_text(ComparedValue::Average, "", Operator::Equal, "1"),
              "no compared-value-option");
  EXPECT_SAYS(error_text(ComparedValue::Custom, "", Operator::Equal, ""),
              "name of a registered function");
  EXPECT_SAYS(error_text(ComparedValue::Element, "0,0", Operator::Equal, ""),
              "offered: 0 numbers in supplied-value");
  EXPECT_SAYS(error_text(ComparedValue::Element, "0,0", Operator::NotInsideRange, "4"),
              "offered: 1 numbers in supplied-value\n  needed: 2");
  EXPECT_EQ(error_text(ComparedValue::Element, "0,0", Operator::LessOrEqual, "4"), "");
  EXPECT_EQ(error_text(ComparedValue::Element, "0,0", Operator::InRange, "4,5"), "");
  EXPECT_EQ(error_text(ComparedValue::Custom, "mine", Operator::InRange, ""), "");
}

}  // namespace condition_test
}  // namespace weir::condition
