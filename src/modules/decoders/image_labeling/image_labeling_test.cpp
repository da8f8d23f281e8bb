// Tests of image_labeling: the chosen label for every element type, and unusable label files.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <fstream>

#include "core/tensor/float16.hpp"
#include "decoder_test_support.hpp"
#include "says.hpp"

namespace weir::testing_decoders {
namespace image_labeling_test {

std::string label_file(const std::string& text) {
  const std::string path = testing::TempDir() + "weir-image-labeling-test.txt";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}
template <class T>
Outcome labelled(const std::string& labels, const Tensor<T>& scores) {
  return decode("image_labeling", {{"option1", label_file(labels)}}, scores);
}
// Returns the label with its terminating zero, or the error.
std::string label(const Outcome& outcome) {
  if (!outcome.error.empty() || outcome.sink.memories.size() != 1) return outcome.error;
  const Bytes& bytes = outcome.sink.memories[0];
  return {bytes.begin(), bytes.end()};
}
std::string zero_terminated(std::string text) {
  return text + '\0';
}
constexpr auto kUInt8 = ElementType::UInt8;

TEST(ImageLabeling, GivesTheLabelOfTheHighestScore) {
  const auto out = labelled("cat\ndog\nfish\n", Tensor<uint8_t>{kUInt8, "3:1", {1, 200, 3}});
  EXPECT_EQ(label(out), zero_terminated("dog"));
  EXPECT_EQ(out.sink.caps, "text/x-raw,format=(string)utf8");
}

TEST(ImageLabeling, TakesTheFirstOfEquals) {
  EXPECT_EQ(label(labelled("a\nb\nc", Tensor<uint8_t>{kUInt8, "3", {1, 7, 7}})),
            zero_terminated("b"));
}

TEST(ImageLabeling, TakesEveryShapeOfOneScoreAClass) {
  for (const char* shape : {"3", "3:1", "3:1:1", "3:1:1:1"})
    EXPECT_EQ(label(labelled("a\nb\nc", Tensor<uint8_t>{kUInt8, shape, {0, 0, 9}})),
              zero_terminated("c"))
        << shape;
}

template <class T>
void expect_last(ElementType type, std::vector<T> scores) {
  EXPECT_EQ(label(labelled("a\nb\nc", Tensor<T>{type, "3:1", std::move(scores)})),
            zero_terminated("c"))
      << static_cast<int>(type);
}
TEST(ImageLabeling, ReadsEveryElementType) {
  const auto half = [](float value) { return float16(value); };
  expect_last<int8_t>(ElementType::Int8, {-128, -3, -1});
  expect_last<uint8_t>(ElementType::UInt8, {127, 128, 255});
  expect_last<int16_t>(ElementType::Int16, {-32768, -300, 300});
  expect_last<uint16_t>(ElementType::UInt16, {300, 32768, 65535});
  expect_last<int32_t>(ElementType::Int32, {-70000, 70000, 70001});
  expect_last<uint32_t>(ElementType::UInt32, {1, 1u << 31, (1u << 31) + 1});
  expect_last<int64_t>(ElementType::Int64, {INT64_MIN, 0, INT64_MAX});
  expect_last<uint64_t>(ElementType::UInt64, {1, UINT64_MAX - 1, UINT64_MAX});
  expect_last<float>(ElementType::Float32, {-INFINITY, -1e30f, 1e-30f});
  expect_last<double>(ElementType::Float64, {-1, 0.5, 0.5000000001});
  expect_last<float16>(ElementType::Float16, {half(-2), half(-1), half(-0.5f)});
  expect_last<float16>(ElementType::Float16, {half(-1), half(6e-8f), half(65504)});
}

TEST(ImageLabeling, PassesOverNotANumber) {
  const auto best = [](std::vector<float> scores) {
    std::vector<float16> halves(scores.begin(), scores.end());
    const auto of_halves =
        label(labelled("a\nb\nc", Tensor<float16>{ElementType::Float16, "3", halves}));
    const auto of_floats =
        label(labelled("a\nb\nc", Tensor<float>{ElementType::Float32, "3", scores}));
    EXPECT_EQ(of_halves, of_floats);
    return of_floats;
  };
  EXPECT_EQ(best({NAN, 1, 0}), zero_terminated("b"));
  EXPECT_EQ(best({NAN, -4, -3}), zero_terminated("c"));
  EXPECT_EQ(best({0, NAN, 1}), zero_terminated("c"));
  EXPECT_EQ(best({NAN, NAN, NAN}), zero_terminated("a"));
}

TEST(ImageLabeling, ReadsFilesWithCarriageReturns) {
  EXPECT_EQ(label(labelled("cat\r\ndog\r\n", Tensor<uint8_t>{kUInt8, "2", {0, 1}})),
            zero_terminated("dog"));
}

TEST(ImageLabeling, TakesAByteOrderMarkAway) {
  EXPECT_EQ(
      label(labelled("\xEF\xBB\xBF\xC3\xA9t\xC3\xA9\nhiver", Tensor<uint8_t>{kUInt8, "2", {1, 0}})),
      zero_terminated("\xC3\xA9t\xC3\xA9"));
}

TEST(ImageLabeling, RefusesLabelsThatAreNoUtf8) {
  const Tensor<uint8_t> scores{kUInt8, "2", {1, 0}};
  const auto error = labelled("hiver\n\xE9t\xE9\n", scores).error;  // ISO 8859-1
  EXPECT_SAYS(error, "WEIR-4002: line 2 of the label file is not UTF-8");
  EXPECT_SAYS(error, "needed: labels in UTF-8");
  EXPECT_SAYS(error, "fix: iconv -f ISO-8859-1 -t UTF-8 ");
  EXPECT_SAYS(labelled(std::string("a\0b\nc", 5), scores).error, "line 1 of the label file");
  EXPECT_SAYS(labelled("\xFF\xFE", scores).error, "line 1 of the label file");
}

TEST(ImageLabeling, NeedsALabelFile) {
  const Tensor<uint8_t> scores{kUInt8, "2", {0, 1}};
  EXPECT_SAYS(decode("image_labeling", {}, scores).error, "has no label file");
  EXPECT_SAYS(decode("image_labeling", {{"option1", ""}}, scores).error, "has no label file");
  for (const char* path : {"/nowhere/labels.txt", "/tmp", "/dev/null"}) {
    const auto error = decode("image_labeling", {{"option1", path}}, scores).error;
    EXPECT_SAYS(error, "WEIR-4001");
    EXPECT_SAYS(error, path);
    EXPECT_SAYS(error, "fix: option1=");
  }
  for (const char* nothing : {"", "\n"})
    EXPECT_SAYS(labelled(nothing, scores).error, "WEIR-4002: the label file is empty");
}

TEST(ImageLabeling, RefusesOtherShapes) {
  for (const char* shape : {"3:2", "1:6", "3:1:2", "3:1:1:2"}) {
    const auto error = labelled("a\nb\nc", Tensor<uint8_t>{kUInt8, shape, Bytes(6)}).error;
    EXPECT_SAYS(error, "WEIR-2001");
    EXPECT_SAYS(error, "one score for each class");
    EXPECT_SAYS(error, std::string("uint8 ") + shape);
  }
}

TEST(ImageLabeling, RefusesFramesThatAreNotWhatTheySay) {
  const Tensor<uint8_t> good{kUInt8, "3", {1, 2, 3}};
  const infer::Decoder::Options options{{"option1", label_file("a\nb\nc")}};
  EXPECT_SAYS(decode_frame("image_labeling", options, good.info(), {}).error,
              "WEIR-2004: mode=image_labeling got a frame without tensors");
  const auto error = labelled("a\nb\nc", Tensor<uint8_t>{kUInt8, "3", {1, 2}}).error;
  EXPECT_SAYS(error, "WEIR-2004");
  EXPECT_SAYS(error, "offered: 2 bytes");
  EXPECT_SAYS(error, "needed: uint8 3");
  EXPECT_SAYS(labelled("a", Tensor<float>{ElementType::End, "1", {1}}).error, "WEIR-2001");
}

TEST(ImageLabeling, NamesTheMissingLabel) {
  const auto error = labelled("cat\ndog", Tensor<uint8_t>{kUInt8, "3", {0, 0, 9}}).error;
  EXPECT_SAYS(error, "WEIR-4002: class 2 has no label");
  EXPECT_SAYS(error, "2 lines");
  EXPECT_SAYS(labelled("a\n\nc", Tensor<uint8_t>{kUInt8, "3", {0, 9, 0}}).error,
              "class 1 has no label");
}

}  // namespace image_labeling_test
}  // namespace weir::testing_decoders
