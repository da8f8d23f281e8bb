// Files of MOTChallenge: what is read and what is refused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/mot_truth.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::evaluate {
namespace mot_truth_test {

constexpr char kInfo[] =
    "[Sequence]\nname=MOT17-02\nimDir=img1\nframeRate=30\nseqLength=3\nimWidth=640\n"
    "imHeight=480\nimExt=.png\n";

SequenceInfo info() {
  return {"test", "img1", ".jpg", 30, 3, 640, 480};
}
Result<std::vector<TruthTracks>> read(const std::string& text) {
  return parse_mot_truth("gt.txt", text, info());
}
std::string refused(const std::string& text) {
  const auto truth = read(text);
  return truth ? "it was read" : truth.error().message();
}

TEST(SequenceInfo, IsThatOfMotChallenge) {
  const auto sequence = parse_sequence_info("seqinfo.ini", kInfo);
  ASSERT_TRUE(sequence);
  EXPECT_EQ(sequence->name, "MOT17-02");
  EXPECT_EQ(sequence->folder, "img1");
  EXPECT_EQ(sequence->extension, ".png");
  EXPECT_EQ(sequence->frame_rate, 30);
  EXPECT_EQ(sequence->frames, 3U);
  EXPECT_EQ(sequence->width, 640U);
  EXPECT_EQ(sequence->height, 480U);
}

TEST(SequenceInfoRefused, ValuesThatAreMissingOrNotPossible) {
  for (const char* key : {"frameRate", "seqLength", "imWidth", "imHeight"}) {
    std::string text = kInfo;
    const size_t begin = text.find(key);
    text.erase(begin, text.find('\n', begin) - begin + 1);
    const auto without = parse_sequence_info("seqinfo.ini", text);
    ASSERT_FALSE(without) << key;
    EXPECT_SAYS(without.error().message(), "no valid " + std::string(key));
    for (const char* value : {"0", "-1", "many", "1e99"}) {
      const auto wrong = parse_sequence_info("seqinfo.ini", text + key + "=" + value + "\n");
      ASSERT_FALSE(wrong) << key << value;
      EXPECT_SAYS(wrong.error().message(), std::string(key) + "=" + value);
    }
  }
  EXPECT_FALSE(parse_sequence_info("seqinfo.ini", "not an ini file"));
}

TEST(MotTruth, HasCountedAndNeutralObjects) {
  const auto truth = read(
      "1,1,10,20,30,40,1,1,1\n1,2,10,20,30,40,0,8,1\r\n\n3,1,11,20,30,40\n"
      "3,5,11,20,30,40,0,3,1\n");
  ASSERT_TRUE(truth);
  ASSERT_EQ(truth->size(), 3U);
  ASSERT_EQ((*truth)[0].counted.size(), 1U);
  EXPECT_EQ((*truth)[0].counted[0].box, (Rectangle{9, 19, 30, 40}));  // the file counts from 1
  EXPECT_EQ((*truth)[0].neutral.at(0).track, 2);
  EXPECT_TRUE((*truth)[1].counted.empty());
  EXPECT_EQ((*truth)[2].counted.size(), 1U);
  EXPECT_TRUE((*truth)[2].neutral.empty());  // class 3, a car, is no distractor
}

TEST(MotTruthRefused, LinesThatCannotBeRead) {
  for (const char* line : {"1,1,10,20,30", "1,1,a,20,30,40", "1 1 10 20 30 40", "1,1,nan,20,30,40",
                           "1,1,10,20,inf,40", "1,1,10,20,1e999,40", "1,1,10,20,30,40,,"})
    EXPECT_SAYS(refused(line), "a line of the truth cannot be read");
  EXPECT_SAYS(refused("1,1,10,20,30,40\nbad"), "gt.txt: line 2: bad");
}

TEST(MotTruthRefused, FramesThatTheSequenceDoesNotHave) {
  for (const char* line :
       {"0,1,10,20,30,40", "4,1,10,20,30,40", "1.5,1,10,20,30,40", "1e300,1,10,20,30,40"})
    EXPECT_SAYS(refused(line), "a frame from 1 to 3");
}

TEST(MotTruthRefused, TruthThatContradictsItself) {
  EXPECT_SAYS(refused("1,1,10,20,30,40\n1,1,90,20,30,40"),
              "a track has two boxes in the same frame");
  EXPECT_SAYS(refused("1,1.5,10,20,30,40"), "the number of a track is not a whole number");
  EXPECT_SAYS(refused("1,1,10,20,0,40"), "a box has no area");
  EXPECT_SAYS(refused("1,1,641,20,5,40"), "a box is outside of its picture");
  EXPECT_SAYS(refused("1,1,641,20,5,40"), "640 x 480");
  EXPECT_TRUE(read("1,1,640,20,5,40"));  // the last column
}

TEST(NeutralObjects, TakeTheirBoxesAway) {
  const TruthTracks truth{{{1, {0, 0, 10, 10}}}, {{2, {100, 0, 10, 10}}}};
  const auto frame =
      without_neutral(truth, {{7, {0, 0, 10, 10}}, {8, {101, 0, 10, 10}}, {9, {200, 0, 10, 10}}});
  ASSERT_EQ(frame.found.size(), 2U);
  EXPECT_EQ(frame.found[0].track, 7);
  EXPECT_EQ(frame.found[1].track, 9);
  EXPECT_EQ(frame.truth.size(), 1U);
}

TEST(NeutralObjects, DoNotTakeBoxesOfCountedOnes) {
  const TruthTracks truth{{{1, {0, 0, 10, 10}}}, {{2, {1, 0, 10, 10}}}};
  EXPECT_EQ(without_neutral(truth, {{7, {0, 0, 10, 10}}}).found.size(), 1U);
}

}  // namespace mot_truth_test
}  // namespace weir::evaluate
