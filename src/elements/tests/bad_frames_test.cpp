// Buffers that are not what the caps say, into every element.
#include "elements/tests/bad_input_bench.hpp"

namespace {

using namespace weir::testing_bad_input;

class BadFrame : public EachElement {
 protected:
  // What a buffer of another size brings: "" where more or fewer bytes are frames too.
  std::string expected(size_t bytes) const {
    const std::string name = GetParam().name;
    if (name == "sink" || name == "overlay") return "";  // hands on what it gets
    if (bytes == 0) return "WEIR-2004: ";
    const bool video = name.starts_with("converter") && GetParam().caps.starts_with("video");
    if (video || name.starts_with("preprocess"))
      return bytes < GetParam().bytes ? "WEIR-2004: a video buffer is shorter than its caps say"
             : bytes >= 2 * GetParam().bytes ? "WEIR-2004: a video buffer holds more than one frame"
                                             : "";
    if (name == "converter_audio") return bytes % 4 ? "WEIR-2004: " : "";
    if (name == "converter_bytes") return bytes % 16 ? "WEIR-2004: " : "";
    return "WEIR-2004: a buffer has another size than its caps say";
  }
};

TEST_P(BadFrame, OfAnotherSizeIsNamedOrTaken) {
  const Subject& subject = GetParam();
  for (const size_t bytes :
       {size_t{0}, size_t{1}, subject.bytes - 1, subject.bytes + 1, 3 * subject.bytes}) {
    Bench bench(subject.line);
    ASSERT_EQ(bench.start(subject.caps), "");
    EXPECT_EQ(bench.push(zeros(subject.bytes)), "");
    const std::string error = bench.push(zeros(bytes));
    const std::string words = expected(bytes);
    EXPECT_EQ(error.empty(), words.empty()) << bytes << " bytes: " << error;
    EXPECT_SAYS(error, words) << bytes << " bytes";
    if (!error.empty()) {
      EXPECT_EQ(bench.dropped_when_told(), 1u) << "counted before it is told";
    }
    expect_sound_again(bench, subject, 2);
  }
}

TEST_P(BadFrame, InMemoriesOfOddSizesIsReadAsAWhole) {
  const Subject& subject = GetParam();
  Bench bench(subject.line);
  ASSERT_EQ(bench.start(subject.caps), "");
  GstBuffer* in = zeros(1);
  in = gst_buffer_append(in, zeros(subject.bytes - 4));
  in = gst_buffer_append(in, zeros(3));
  EXPECT_EQ(bench.push(in), "");
  expect_sound_again(bench, subject, 1);
}

TEST_P(BadFrame, WithoutCapsIsNamed) {
  const Subject& subject = GetParam();
  Bench bench(subject.line);
  bench.start(subject.caps);
  bench.stop();
  ASSERT_EQ(bench.start_without_caps(), "");
  const std::string error = bench.push(zeros(subject.bytes));
  EXPECT_EQ(error.empty(), std::string(subject.name) == "sink") << error;
  bench.expect_balance(bench.stat("received"));
  bench.stop();
  EXPECT_EQ(bench.start(subject.caps), "");
  EXPECT_EQ(bench.push(zeros(subject.bytes)), "");
}

TEST_P(BadFrame, WithFlagsOfEveryKindIsTaken) {
  const Subject& subject = GetParam();
  Bench bench(subject.line);
  ASSERT_EQ(bench.start(subject.caps), "");
  for (const auto flag : {GST_BUFFER_FLAG_GAP, GST_BUFFER_FLAG_CORRUPTED, GST_BUFFER_FLAG_DISCONT,
                          GST_BUFFER_FLAG_DECODE_ONLY, GST_BUFFER_FLAG_DELTA_UNIT}) {
    GstBuffer* in = zeros(subject.bytes);
    GST_BUFFER_FLAG_SET(in, flag);
    EXPECT_EQ(bench.push(in), "") << flag;
  }
  expect_sound_again(bench, subject, bench.stat("received"));
}

WEIR_FOR_EACH_ELEMENT(BadFrame);

}  // namespace
