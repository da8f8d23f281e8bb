// The description of the samples of a data repository: its bytes, and files that are wrong.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/description.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::dataset {
namespace description_test {

Result<Description> parse(const std::string& text) {
  return parse_description("data.json", text);
}

TEST(Description, OfSamplesOfOneSizeHasTheBytesOfJsonGlib) {
  const Description description{
      .caps = "other/tensors, format=(string)static, dimensions=(string)\"4,2\"",
      .total_samples = 3,
      .sample_size = 24};
  EXPECT_EQ(to_json(description),
            "{\n"
            "  \"gst_caps\" : \"other/tensors, format=(string)static, "
            "dimensions=(string)\\\"4,2\\\"\",\n"
            "  \"total_samples\" : 3,\n"
            "  \"sample_size\" : 24\n"
            "}");
}

TEST(Description, OfSamplesOfDifferentSizesHasOneElementOnEachLine) {
  Description description{.caps = "other/tensors, format=(string)flexible", .total_samples = 2};
  description.sizes = {{0, 276}, {132, 144, 132}, {0, 2}};
  EXPECT_EQ(to_json(description),
            "{\n"
            "  \"gst_caps\" : \"other/tensors, format=(string)flexible\",\n"
            "  \"total_samples\" : 2,\n"
            "  \"sample_offset\" : [\n"
            "    0,\n"
            "    276\n"
            "  ],\n"
            "  \"tensor_size\" : [\n"
            "    132,\n"
            "    144,\n"
            "    132\n"
            "  ],\n"
            "  \"tensor_count\" : [\n"
            "    0,\n"
            "    2\n"
            "  ]\n"
            "}");
}

// As json-glib-format --prettify of json-glib 1.6.6 prints it.
TEST(Description, OfNoSamplesHasEmptyArraysOnOneLine) {
  const Description description{.caps = "a", .sizes = Description::Sizes{}};
  EXPECT_EQ(to_json(description),
            "{\n  \"gst_caps\" : \"a\",\n  \"total_samples\" : 0,\n  \"sample_offset\" : [],\n"
            "  \"tensor_size\" : [],\n  \"tensor_count\" : []\n}");
}

TEST(Description, EscapesTheCaps) {
  const Description description{.caps = "a\t\"b\\\x01\xff", .sample_size = 1};
  EXPECT_SAYS(to_json(description), "\"gst_caps\" : \"a\\t\\\"b\\\\\\u0001\xef\xbf\xbd\",");
}

TEST(Description, IsReadAsItWasWritten) {
  Description description{.caps = "image/png", .total_samples = UINT64_MAX, .sample_size = 0};
  EXPECT_EQ(*parse(to_json(description)), description);
  description.sample_size = std::nullopt;
  description.sizes = {{0, INT64_MAX}, {1, 2}, {0, 1}};
  EXPECT_EQ(*parse(to_json(description)), description);
}

TEST(Description, IgnoresMembersThatAreNotKnown) {
  const auto read = parse(R"({"comment":{"by":[1]},"total_samples":4,"gst_caps":"image/gif"})");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->total_samples, 4u);
  EXPECT_FALSE(read->sample_size);
  EXPECT_FALSE(read->sizes);
}

TEST(Description, NamesTheMemberThatIsMissing) {
  EXPECT_REFUSED(parse("{}"), SAMPLES_INVALID,
                 "a member is missing\n  offered: data.json: no \"gst_caps\"");
  EXPECT_REFUSED(parse(R"({"gst_caps":"a"})"), SAMPLES_INVALID, "no \"total_samples\"");
  EXPECT_REFUSED(parse(R"({"gst_caps":"a","total_samples":1,"tensor_size":[]})"), SAMPLES_INVALID,
                 "no \"sample_offset\"");
}

TEST(Description, NamesTheValueThatIsWrong) {
  EXPECT_REFUSED(parse("[1]"), SAMPLES_INVALID, "it is not an object\n  offered: data.json: [1]");
  EXPECT_REFUSED(parse(R"({"gst_caps":5})"), SAMPLES_INVALID, "gst_caps is not a string");
  for (const char* value : {"-1", "1.5", "\"3\"", "null", "true", "1e30", "99999999999999999999"})
    EXPECT_REFUSED(parse(std::string(R"({"gst_caps":"a","total_samples":)") + value + "}"),
                   SAMPLES_INVALID, "total_samples is not a number of bytes or samples");
  EXPECT_REFUSED(parse(R"({"gst_caps":"a","total_samples":1,"sample_size":-4})"), SAMPLES_INVALID,
                 "sample_size is not a number of bytes or samples\n  offered: data.json: -4");
  EXPECT_REFUSED(parse(R"({"gst_caps":"a","total_samples":1,"sample_offset":3})"), SAMPLES_INVALID,
                 "sample_offset is not an array");
  EXPECT_REFUSED(parse(R"({"gst_caps":"a","total_samples":1,"sample_offset":[0,"x"]})"),
                 SAMPLES_INVALID, "sample_offset[1] is not a number");
}

TEST(Description, CutsLongValuesInErrors) {
  const auto refused = parse("[" + std::string(1000, '1') + "]");
  ASSERT_FALSE(refused);
  EXPECT_LT(refused.error().message().size(), 600u);
}

TEST(Description, NamesThePlaceWhereItIsNotJson) {
  EXPECT_REFUSED(parse(""), SAMPLES_INVALID, "is not JSON");
  EXPECT_REFUSED(parse("{\"gst_caps\" : }"), SAMPLES_INVALID, "at character 15:");
  EXPECT_REFUSED(parse("{\"gst_caps\":\"\xff\"}"), SAMPLES_INVALID, "is not JSON");
  EXPECT_REFUSED(parse("{\"a\":1e999}"), SAMPLES_INVALID, "a number is too large");
  EXPECT_REFUSED(parse("{"), SAMPLES_INVALID, "fix: python3 -m json.tool data.json");
}

TEST(Description, RejectsDeepNesting) {
  const std::string deep(100000, '[');
  EXPECT_REFUSED(parse(deep), SAMPLES_INVALID, "it is nested too deeply");
  EXPECT_REFUSED(parse("{\"x\":" + deep), SAMPLES_INVALID, "it is nested too deeply");
}

}  // namespace description_test
}  // namespace weir::dataset
