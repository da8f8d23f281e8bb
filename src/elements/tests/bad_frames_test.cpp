// Buffers that do not match their caps, pushed into every element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <set>
#include <string_view>

#include "elements/tests/bad_input_bench_test_support.hpp"

namespace bad_frames_test {

using namespace weir::testing_bad_input;

class BadFrame : public EachElement {
 protected:
  // The error for a buffer of another size: "" if more or fewer bytes are also valid frames.
  std::string expected(size_t bytes) const {
    const size_t whole = GetParam().bytes;
    switch (GetParam().sizes) {
      case Sizes::Any:
        return "";
      case Sizes::Video:
        return bytes == 0           ? "WEIR-2004: "
               : bytes < whole      ? "WEIR-2004: a video buffer is smaller than its caps require"
               : bytes >= 2 * whole ? "WEIR-2004: a video buffer holds more than one frame"
                                    : "";
      case Sizes::Words:
        return bytes == 0 || bytes % 4 != 0 ? "WEIR-2004: " : "";
      case Sizes::Rows:
        return bytes == 0 || bytes % 16 != 0 ? "WEIR-2004: " : "";
      case Sizes::Headers:
        return "WEIR-200";
      case Sizes::Exact:
        break;
    }
    return bytes == 0 ? "WEIR-2004: " : "WEIR-2004: the size of a buffer does not match its caps";
  }
};

// A new element needs an entry in the table.
TEST(BadInput, IsTestedOnEveryElementOfThePlugIn) {
  std::set<std::string> tried{"datareposrc"};  // has no input; damaged_files_test.cpp
  for (const auto& subject : subjects())
    tried.insert(subject.line.substr(0, subject.line.find(' ')));
  const auto names = weir::test::element_names();
  EXPECT_EQ(tried, std::set<std::string>(names.begin(), names.end()));
}

TEST_P(BadFrame, OfAnotherSizeIsReportedOrAccepted) {
  const Subject& subject = GetParam();
  for (const size_t bytes :
       {size_t{0}, size_t{1}, subject.bytes - 1, subject.bytes + 1, 3 * subject.bytes}) {
    Bench bench(subject);
    ASSERT_EQ(bench.start(subject.caps), "");
    EXPECT_EQ(bench.push(subject.good_frame()), "");
    const std::string error = bench.push(zeros(bytes));
    const std::string message = expected(bytes);
    EXPECT_EQ(error.empty(), message.empty()) << bytes << " bytes: " << error;
    EXPECT_SAYS(error, message) << bytes << " bytes";
    if (!error.empty() && std::string_view(subject.counter) == "received") {
      EXPECT_GE(bench.dropped_with_warning(), 1u) << "counted before it is posted";
    }
    expect_sound_again(bench, subject, 2);
  }
}

TEST_P(BadFrame, InMemoriesOfOddSizesIsReadAsAWhole) {
  const Subject& subject = GetParam();
  Bench bench(subject);
  ASSERT_EQ(bench.start(subject.caps), "");
  GstBuffer* in = zeros(1);
  in = gst_buffer_append(in, zeros(subject.bytes - 4));
  in = gst_buffer_append(in, zeros(3));
  const std::string error = bench.push(in);
  // Each memory of a flexible or sparse frame starts with a header.
  EXPECT_EQ(error.empty(), subject.sizes != Sizes::Headers) << error;
  expect_sound_again(bench, subject, 1);
}

TEST_P(BadFrame, WithoutCapsIsReported) {
  const Subject& subject = GetParam();
  Bench bench(subject);
  bench.start(subject.caps);
  bench.stop();
  ASSERT_EQ(bench.start_without_caps(), "");
  const std::string error = bench.push(subject.good_frame());
  const std::string name = subject.name;
  EXPECT_EQ(error.empty(), name == "sink" || name == "join" || name == "debug") << error;
  bench.expect_balance(bench.received());
  bench.stop();
  EXPECT_EQ(bench.start(subject.caps), "");
  EXPECT_EQ(bench.push(subject.good_frame()), "");
}

TEST_P(BadFrame, WithFlagsOfEveryKindIsAccepted) {
  const Subject& subject = GetParam();
  Bench bench(subject);
  ASSERT_EQ(bench.start(subject.caps), "");
  for (const auto flag : {GST_BUFFER_FLAG_GAP, GST_BUFFER_FLAG_CORRUPTED, GST_BUFFER_FLAG_DISCONT,
                          GST_BUFFER_FLAG_DECODE_ONLY, GST_BUFFER_FLAG_DELTA_UNIT}) {
    GstBuffer* in = subject.good_frame();
    GST_BUFFER_FLAG_SET(in, flag);
    EXPECT_EQ(bench.push(in), "") << flag;
  }
  expect_sound_again(bench, subject, bench.received());
}

WEIR_FOR_EACH_ELEMENT(BadFrame);

// 4 values in a tensor whose dimensions give a million: reading by dimensions would overrun.
TEST(SparseTensorInAFlexibleStream, IsRejectedBeforeItIsRead) {
  std::vector<uint32_t> words(32 + 5);
  words[0] = 0xFEEDCCED, words[1] = 0xDE001000, words[2] = 5, words[3] = 1000000;
  words[19] = 2, words[20] = 4, words[21] = 4;  // sparse, a tensor, 4 values and their indices
  const std::string flexible = "other/tensors,format=flexible,framerate=30/1";
  for (const std::string& line :
       {std::string("tensor_converter"), std::string("tensor_transform mode=clamp option=0:9"),
        fake_filter(), std::string("tensor_decoder mode=octet_stream")}) {
    Bench bench(line);
    ASSERT_EQ(bench.start(flexible), "") << line;
    GstBuffer* in = gst_buffer_new_allocate(nullptr, 128 + 20, nullptr);
    gst_buffer_fill(in, 0, words.data(), 128 + 20);
    EXPECT_SAYS(bench.push(in), "WEIR-2002: a tensor of a flexible stream is sparse") << line;
    bench.expect_balance(1);
  }
}

}  // namespace bad_frames_test
