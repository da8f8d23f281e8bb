// Timestamps that are missing, go backwards or are out of range, in every element; extreme frame
// rates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/bad_input_bench_test_support.hpp"

namespace bad_times_test {

using namespace weir::testing_bad_input;

class BadTime : public EachElement {};

TEST_P(BadTime, IsAcceptedAndCounted) {
  const Subject& subject = GetParam();
  constexpr GstClockTime kNone = GST_CLOCK_TIME_NONE, kHuge = kNone - 1;
  const std::pair<GstClockTime, GstClockTime> times[] = {
      {kNone, kNone},           {5 * GST_SECOND, kNone}, {3 * GST_SECOND, 1}, {0, 0},
      {kHuge, kHuge},           {kHuge, kNone},          {kNone, kHuge},      {kNone, kNone},
      {G_MAXINT64, G_MAXINT64}, {kNone, kNone},          {7, kNone},          {kNone, kNone}};
  Bench bench(subject);
  ASSERT_EQ(bench.start(subject.caps), "");
  for (const auto& [pts, duration] : times) {
    GstBuffer* in = subject.good_frame();
    GST_BUFFER_PTS(in) = pts;
    GST_BUFFER_DTS(in) = pts;
    GST_BUFFER_DURATION(in) = duration;
    EXPECT_EQ(bench.push(in), "") << pts << " for " << duration;
  }
  bench.expect_balance(std::size(times));
  if (std::string(subject.name) == "converter") {
    EXPECT_EQ(bench.stat("backwards-times"), 4u);
    EXPECT_SAYS(bench.warning(), "WEIR-2008: a timestamp goes backwards");
    EXPECT_EQ(bench.last_time(), 7 + GST_SECOND / 30) << "missing times continue from 7";
  }
  expect_sound_again(bench, subject, std::size(times));
}

// As from filesrc with a capsfilter; G_DEBUG=fatal-criticals.
TEST_P(BadTime, InASegmentOfBytesIsAcceptedAndCounted) {
  const Subject& subject = GetParam();
  const GstClockTime times[] = {0, GST_CLOCK_TIME_NONE, GST_SECOND};
  Bench bench(subject);
  ASSERT_EQ(bench.start(subject.caps), "");
  bench.begin_segment(GST_FORMAT_BYTES);
  for (const GstClockTime time : times) {
    GstBuffer* in = subject.good_frame();
    GST_BUFFER_PTS(in) = time;
    EXPECT_EQ(bench.push(in), "") << time;
  }
  expect_sound_again(bench, subject, std::size(times));
}

TEST_P(BadTime, OfAnExtremeFrameRateIsValid) {
  const Subject& subject = GetParam();
  if (subject.caps.find("framerate") == std::string::npos) return;  // audio uses its sample rate
  const std::string name = subject.name;
  if (name == "join" || name == "reposrc") return;  // another branch or a property fixes the rate
  for (const char* rate : {"0/1", "1/2147483647", "2147483647/1"}) {
    const std::string caps =
        subject.caps.substr(0, subject.caps.find("framerate")) + "framerate=" + rate;
    Bench bench(subject);
    ASSERT_EQ(bench.start(caps), "") << rate;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(bench.push(subject.good_frame()), "") << rate;
    expect_sound_again(bench, subject, 3);
  }
}

WEIR_FOR_EACH_ELEMENT(BadTime);

}  // namespace bad_times_test
