// Tests of image_segment: pixels of each kind of tensor, and input that it rejects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/decoders/decoder_test_support.hpp"

namespace weir::decoders {
namespace image_segment_test {

constexpr const char* kMode = "image_segment";

DecoderOptions options(const std::string& scheme, const std::string& labels = "") {
  DecoderOptions out{{"option1", scheme}};
  if (!labels.empty()) out.emplace_back("option2", labels);
  return out;
}
// The pixels as numbers 0xAABBGGRR.
std::vector<uint32_t> pixels_of(const Bytes& bytes) {
  std::vector<uint32_t> out;
  for (size_t i = 0; i + 4 <= bytes.size(); i += 4)
    out.push_back(bytes[i] | uint32_t{bytes[i + 1]} << 8 | uint32_t{bytes[i + 2]} << 16 |
                  uint32_t{bytes[i + 3]} << 24);
  return out;
}
std::vector<uint32_t> pixels(const DecoderOptions& options, const TestTensor& tensor) {
  TestDecoder decoder(kMode, options);
  if (decoder.error.empty() && decoder.configure({tensor})) decoder.decode({tensor});
  EXPECT_EQ(decoder.error, "");
  return pixels_of(decoder.output);
}
uint32_t color(uint32_t index, uint32_t labels) {
  return index == 0 ? 0 : (0xFFFFFF / (labels + 1) * index) | 0xFF000000;
}
using Pixels = std::vector<uint32_t>;

TEST(ImageSegment, PaintsTheBestClassOfEachPixel) {
  EXPECT_EQ(pixels(options("tflite-deeplab", "2"),
                   {"3:2:2", {0, 1, 2, /**/ 3, 2, 1, /**/ 0, 2, 1, /**/ 0, 0.5f, 0.25f}}),
            (Pixels{color(2, 2), 0, color(1, 2), 0}));
}

TEST(ImageSegment, PaintsClassNumbers) {
  EXPECT_EQ(pixels(options("snpe-deeplab", "3"), {"3:2", {0, 1, 2, 3, 2.9f, 0}}),
            (Pixels{0, color(1, 3), color(2, 3), color(3, 3), color(2, 3), 0}));
}

TEST(ImageSegment, PaintsDepthsAsGrayLevels) {
  EXPECT_EQ(pixels(options("snpe-depth"), {"1:2:2", {0, 1, 2, 4}}),
            (Pixels{0xFF000000, 0xFF3F3F3F, 0xFF7F7F7F, 0xFFFFFFFF}));
  EXPECT_EQ(pixels(options("snpe-depth"), {"1:2:1", {0, 0}}), (Pixels{0, 0}));
}

TEST(ImageSegment, HasTwentyClassesByDefault) {
  for (const char* labels : {"", "20"}) {
    EXPECT_EQ(pixels(options("snpe-deeplab", labels), {"2:1", {20, 1}}),
              (Pixels{0xFFF3CF3C, 0xFF0C30C3}));
    std::vector<float> scores(21);
    scores[20] = 1;
    EXPECT_EQ(pixels(options("tflite-deeplab", labels), {"21:1:1", scores}), (Pixels{0xFFF3CF3C}));
  }
}

TEST(ImageSegment, SetsTheCapsFromTheTensor) {
  for (const auto& [scheme, shape] : {std::pair{"tflite-deeplab", "21:5:3"},
                                      {"tflite-deeplab", "21:5:3:1"},
                                      {"snpe-deeplab", "5:3"},
                                      {"snpe-deeplab", "5:3:1:1"},
                                      {"snpe-depth", "1:5:3"}}) {
    TestDecoder decoder(kMode, options(scheme));
    EXPECT_TRUE(decoder.configure({{shape, {}}})) << decoder.error;
    EXPECT_EQ(decoder.caps, "video/x-raw,format=(string)RGBA,width=(int)5,height=(int)3") << scheme;
  }
}

// Pictures are decoded in parts; each pixel must be decoded once and at its place.
TEST(ImageSegment, DecodesPicturesOfManyParts) {
  constexpr size_t kWidth = 131, kHeight = 97;
  const std::string size = std::to_string(kWidth) + ":" + std::to_string(kHeight);
  std::vector<float> numbers(kWidth * kHeight), scores(3 * numbers.size());
  Pixels expected, gray;
  for (size_t i = 0; i < numbers.size(); ++i) {
    const size_t index = i * 7919 % 4093 % 3;
    numbers[i] = static_cast<float>(index);
    scores[3 * i + index] = 1;
    expected.push_back(color(static_cast<uint32_t>(index), 2));
    gray.push_back(index == 0 ? 0xFF000000 : index == 1 ? 0xFF7F7F7F : 0xFFFFFFFF);
  }
  EXPECT_EQ(pixels(options("snpe-deeplab", "2"), {size, numbers}), expected);
  EXPECT_EQ(pixels(options("tflite-deeplab", "2"), {"3:" + size, scores}), expected);
  EXPECT_EQ(pixels(options("snpe-depth"), {"1:" + size, numbers}), gray);
}

TEST(ImageSegment, ReadsMemoryOfAnyAlignment) {
  TestDecoder decoder(kMode, options("snpe-depth"));
  const TestTensor tensor{"1:2:1", {1, 2}};
  ASSERT_TRUE(decoder.configure({tensor}));
  TestTensor shifted = tensor;
  shifted.bytes.insert(shifted.bytes.begin(), 0);
  weir_tensor memory = shifted.tensor();
  memory.data = static_cast<uint8_t*>(memory.data) + 1;
  memory.bytes = memory.capacity = 8;
  EXPECT_EQ(pixels_of(decoder.decode_memory({memory})), (Pixels{0xFF7F7F7F, 0xFFFFFFFF}));
}

TEST(ImageSegment, KeepsItsOwnOptions) {
  TestDecoder few(kMode, options("snpe-deeplab", "1"));
  TestDecoder many(kMode, options("snpe-deeplab", "9"));
  const TestTensor tensor{"1:1", {1}};
  EXPECT_EQ(pixels_of(few.decode({tensor})), (Pixels{color(1, 1)}));
  EXPECT_EQ(pixels_of(many.decode({tensor})), (Pixels{color(1, 9)}));
  EXPECT_EQ(pixels_of(few.decode({tensor})), (Pixels{color(1, 1)}));
}

TEST(ImageSegment, NeedsAKind) {
  const auto error = error_of(kMode, {}, {});
  EXPECT_SAYS(error, "WEIR-1004: mode=image_segment does not know what the tensor holds");
  EXPECT_SAYS(error, "needed: one of: tflite-deeplab, snpe-deeplab, snpe-depth");
  EXPECT_SAYS(error, "fix: tensor_decoder mode=image_segment option1=tflite-deeplab");
  EXPECT_SAYS(error_of(kMode, options(""), {}), "offered: no option1");
}

TEST(ImageSegment, GuessesTheKindThatWasMeant) {
  const auto error = error_of(kMode, options("snpe-dept"), {});
  EXPECT_SAYS(error, "WEIR-1004: option1 is not a kind of segmentation");
  EXPECT_SAYS(error, "offered: option1=snpe-dept");
  EXPECT_SAYS(error, "did you mean snpe-depth?");
  EXPECT_SAYS(error, "fix: option1=snpe-depth");
  EXPECT_SAYS(error_of(kMode, options("unet"), {}), "needed: one of: tflite-deeplab");
}

TEST(ImageSegment, NeedsANumberOfClasses) {
  for (const char* labels : {"0", "65536", "99999999999"}) {
    const auto error = error_of(kMode, options("snpe-deeplab", labels), {});
    EXPECT_SAYS(error, "WEIR-1004: option2 is not a number of classes");
    EXPECT_SAYS(error, std::string("offered: option2=") + labels);
    EXPECT_SAYS(error, "needed: a whole number from 1 to 65535");
    EXPECT_SAYS(error, "fix: option2=20");
  }
  for (const char* labels : {"-1", "2.5", "many", "20x", " "})
    EXPECT_SAYS(error_of(kMode, options("tflite-deeplab", labels), {}),
                "WEIR-1001: option2 is not a number of classes");
}

TEST(ImageSegment, RejectsAnotherNumberOfScores) {
  const auto error =
      error_of(kMode, options("tflite-deeplab"), {{"11:4:2", std::vector<float>(88)}});
  EXPECT_SAYS(error, "WEIR-2001: the tensor has a different number of classes than option2");
  EXPECT_SAYS(error, "offered: float32 11:4:2");
  EXPECT_SAYS(error, "needed: float32 21:W:H");
  EXPECT_SAYS(error, "fix: option2=10");
}

TEST(ImageSegment, RejectsOtherShapes) {
  for (const auto& [scheme, shape] : {std::pair{"tflite-deeplab", "21:2:2:2"},
                                      {"snpe-deeplab", "2:2:2"},
                                      {"snpe-depth", "2:2:2"},
                                      {"snpe-depth", "1:2:2:3"}}) {
    const auto error = error_of(kMode, options(scheme), {{shape, {}}});
    EXPECT_SAYS(error, "WEIR-2001: mode=image_segment cannot read this tensor as a picture");
    EXPECT_SAYS(error, std::string("offered: float32 ") + shape);
    EXPECT_SAYS(error, "fix: other/tensors,format=static,num_tensors=1,dimensions=(string)");
  }
}

TEST(ImageSegment, RejectsOtherTypes) {
  const std::vector<uint8_t> bytes(4);
  const auto error = error_of(kMode, options("snpe-deeplab"), {{ElementType::UInt8, "2:2", bytes}});
  EXPECT_SAYS(error, "WEIR-2001");
  EXPECT_SAYS(error, "offered: uint8 2:2");
  EXPECT_SAYS(error, "needed: float32 W:H, a class number for each pixel");
  EXPECT_SAYS(error, "fix: tensor_transform mode=typecast option=float32");
}

TEST(ImageSegment, NeedsAStaticStream) {
  const auto error = error_of(kMode, options("tflite-deeplab"), {});
  EXPECT_SAYS(error, "WEIR-2002: mode=image_segment needs the size of the picture");
  EXPECT_SAYS(error, "fix: tensor_converter ! tensor_decoder");
}

TEST(ImageSegment, RejectsFramesOfAnotherSize) {
  TestDecoder decoder(kMode, options("snpe-depth"));
  decoder.decode(std::vector<TestTensor>{});
  EXPECT_SAYS(decoder.error, "WEIR-2004: mode=image_segment got a frame without tensors");
  decoder.decode({{"1:2:2", {1, 2, 3}}});
  EXPECT_SAYS(decoder.error, "WEIR-2004");
  EXPECT_SAYS(decoder.error, "offered: 12 bytes");
}

TEST(ImageSegment, NamesAClassThatOption2DoesNotInclude) {
  const auto error = error_of(kMode, options("snpe-deeplab", "3"), {{"3:2", {0, 0, 0, 0, 7, 9}}});
  EXPECT_SAYS(error, "WEIR-2001: a pixel has a number that is not a class");
  EXPECT_SAYS(error, "offered: 7 at pixel 1, 1");
  EXPECT_SAYS(error, "needed: numbers from 0 to 3 (option2=3)");
  EXPECT_SAYS(error, "fix: option2=7");
}

TEST(ImageSegment, NamesWhatIsNoClass) {
  for (const auto& [number, text] :
       {std::pair{NAN, "nan"}, {INFINITY, "inf"}, {-INFINITY, "-inf"}, {-2.f, "-2"}}) {
    const auto error = error_of(kMode, options("snpe-deeplab"), {{"2:1", {0, number}}});
    EXPECT_SAYS(error, "a pixel has a number that is not a class");
    EXPECT_SAYS(error, std::string("offered: ") + text + " at pixel 1, 0");
    EXPECT_SAYS(error, "fix: option1=tflite-deeplab");
  }
}

TEST(ImageSegment, NamesADepthThatIsNotFinite) {
  for (const auto& [number, text] :
       {std::pair{NAN, "nan"}, {INFINITY, "inf"}, {-INFINITY, "-inf"}}) {
    const auto error = error_of(kMode, options("snpe-depth"), {{"1:3:2", {0, 1, 2, 3, number, 1}}});
    EXPECT_SAYS(error, "WEIR-2001: a depth is not a finite number");
    EXPECT_SAYS(error, std::string("offered: ") + text + " at pixel 1, 1");
    EXPECT_SAYS(error, "fix: tensor_transform mode=clamp");
  }
}

TEST(ImageSegment, TreatsNotANumberAsNoScore) {
  EXPECT_EQ(pixels(options("tflite-deeplab", "2"), {"3:2:1", {NAN, 1, 2, /**/ NAN, NAN, NAN}}),
            (Pixels{color(2, 2), 0}));
}

}  // namespace image_segment_test
}  // namespace weir::decoders
