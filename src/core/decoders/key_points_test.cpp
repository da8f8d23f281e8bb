// Tests of the default body and of key point files.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/key_points.hpp"

#include "core/decoders/decoder_test_support.hpp"
#include "weir/module.hpp"

namespace weir::decoders {
namespace key_points_test {

using Bones = std::vector<draw::Bone>;

// Why the file is rejected; "" if it is not.
std::string refusal_of_file(const std::string& path) {
  try {
    read_key_point_file("option3", path);
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "";
}
std::string refusal(const std::string& text) {
  return refusal_of_file(file_with("key-points.txt", text));
}
KeyPoints read(const std::string& text) {
  return read_key_point_file("option3", file_with("key-points.txt", text));
}

// docs/compatibility/decoder.md 5.4 lists the connections of both key points of a line.
TEST(KeyPoints, TheDefaultBodyHas14PointsAnd13Lines) {
  const KeyPoints& body = default_key_points();
  ASSERT_EQ(body.names.size(), 14u);
  EXPECT_EQ(body.names[0], "top");
  EXPECT_EQ(body.names[1], "neck");
  EXPECT_EQ(body.names[13], "l_ankle");
  EXPECT_EQ(body.bones, (Bones{{0, 1},
                               {1, 2},
                               {1, 5},
                               {1, 8},
                               {1, 11},
                               {2, 3},
                               {3, 4},
                               {5, 6},
                               {6, 7},
                               {8, 9},
                               {9, 10},
                               {11, 12},
                               {12, 13}}));
}

TEST(KeyPoints, ReadsNamesAndConnections) {
  const KeyPoints body = read("nose 1 2\nleft_eye 0\nright_eye 2\nalone\n");
  EXPECT_EQ(body.names, (std::vector<std::string>{"nose", "left_eye", "right_eye", "alone"}));
  EXPECT_EQ(body.bones, (Bones{{0, 1}, {0, 2}, {2, 2}}));
}

TEST(KeyPoints, TakesBlanksAndCarriageReturns) {
  const KeyPoints body = read(" a  1\t1 \r\nb\t\r\n");
  EXPECT_EQ(body.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(body.bones, (Bones{{0, 1}, {0, 1}}));
}

TEST(KeyPoints, TakesTheLongestNameAndTheMostConnections) {
  const KeyPoints body = read("fifteen_letters 0 0 0 0 0 0 0");
  EXPECT_EQ(body.names[0].size(), 15u);
  EXPECT_EQ(body.bones.size(), 7u);
}

TEST(KeyPoints, RejectsLinesWithoutAName) {
  for (const char* text : {"a 1\n\nb", "a 1\n \t\nb"}) {
    EXPECT_SAYS(refusal(text), "WEIR-4002: line 2 of the key point file has no name");
    EXPECT_SAYS(refusal(text), "needed: a name in each line");
    EXPECT_SAYS(refusal(text), "fix: correct line 2");
  }
}

TEST(KeyPoints, RejectsLongNames) {
  const auto error = refusal("a\nsixteen__letters 0");
  EXPECT_SAYS(error, "WEIR-4002: line 2 of the key point file has a name that is too long");
  EXPECT_SAYS(error, "offered: sixteen__letters (option3=");
  EXPECT_SAYS(error, "needed: names of at most 15 bytes");
  EXPECT_SAYS(error, "fix: sixteen__letter");
}

TEST(KeyPoints, RejectsMoreThanSevenConnections) {
  const auto error = refusal("a 0 0 0 0 0 0 0 0");
  EXPECT_SAYS(error, "WEIR-4002: line 1 of the key point file has too many connections");
  EXPECT_SAYS(error, "offered: a with 8");
  EXPECT_SAYS(error, "needed: at most 7");
}

TEST(KeyPoints, RejectsConnectionsToKeyPointsThatDoNotExist) {
  const auto error = refusal("a 1\nb 2\n");
  EXPECT_SAYS(error, "line 2 of the key point file has a connection to a key point that does not");
  EXPECT_SAYS(error, "offered: 2 (option3=");
  EXPECT_SAYS(error, "needed: an index from 0 to 1");
  EXPECT_SAYS(refusal("a 18446744073709551615"), "does not exist");
}

TEST(KeyPoints, RejectsConnectionsThatAreNotNumbers) {
  for (const char* word : {"b", "-1", "1.0", "1,0", "99999999999999999999"}) {
    const auto error = refusal(std::string("a ") + word + "\nb");
    EXPECT_SAYS(error, "line 1 of the key point file has a connection that is not a number");
    EXPECT_SAYS(error, std::string("offered: ") + word + " (");
    EXPECT_SAYS(error, "fix: nose 1 2");
  }
}

TEST(KeyPoints, GivesTheReasonWhyAFileCannotBeRead) {
  EXPECT_SAYS(refusal_of_file("/nowhere/points.txt"), "WEIR-4001");
  EXPECT_SAYS(refusal_of_file("/nowhere/points.txt"), "offered: option3=/nowhere/points.txt");
  EXPECT_SAYS(refusal_of_file("/nowhere/points.txt"), "No such file or directory");
  EXPECT_SAYS(refusal_of_file("/tmp"), "Is a directory");
  EXPECT_SAYS(refusal(""), "WEIR-4002: the label file is empty");
}

}  // namespace key_points_test
}  // namespace weir::decoders
