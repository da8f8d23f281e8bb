// Tests of tensor_region: bytes of the regions, and input that it rejects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/decoders/decoder_test_support.hpp"
#include "core/tensor/tensor_header.hpp"

namespace weir::decoders {
namespace tensor_region_test {

constexpr const char* kMode = "tensor_region";
using Numbers = std::vector<uint32_t>;

std::string labels(const std::string& text = "background\na\nb\n") {
  return file_with("region-labels.txt", text);
}
// Three anchors: centres y 0.2, 0.5, 0.8 and x 0.3, 0.5, 0.7; heights 0.2 and widths 0.4.
std::string priors() {
  return file_with("region-priors.txt", "0.2 0.5 0.8\n0.3 0.5 0.7\n0.2 0.2 0.2\n0.4 0.4 0.4\n");
}
DecoderOptions options(const std::string& regions = "", const std::string& input = "100:100",
                       const std::string& parameters = priors()) {
  DecoderOptions out{{"option2", labels()}, {"option3", parameters}};
  if (!regions.empty()) out.emplace_back("option1", regions);
  if (!input.empty()) out.emplace_back("option4", input);
  return out;
}
// Boxes that are the priors themselves, and the logits of three classes of each anchor.
std::vector<TestTensor> anchors(const std::vector<float>& logits,
                                const std::vector<float>& boxes = std::vector<float>(12)) {
  return {{"4:1:3", boxes}, {"3:3", logits}};
}
Bytes decoded(const DecoderOptions& options, const std::vector<TestTensor>& tensors) {
  TestDecoder decoder(kMode, options);
  if (decoder.error.empty() && decoder.configure(tensors)) decoder.decode(tensors);
  EXPECT_EQ(decoder.error, "");
  return decoder.output;
}
// The numbers after the header.
Numbers regions(const DecoderOptions& options, const std::vector<TestTensor>& tensors) {
  const Bytes bytes = decoded(options, tensors);
  if (bytes.size() < kTensorHeaderBytes) return {};
  Numbers out((bytes.size() - kTensorHeaderBytes) / 4);
  std::memcpy(out.data(), bytes.data() + kTensorHeaderBytes, 4 * out.size());
  return out;
}
constexpr float kNo = -9;

TEST(TensorRegion, WritesTheBestRegions) {
  // Anchor 1 is the best, then 2; their boxes are the priors in a picture of 100 x 100.
  const auto tensors = anchors({0, kNo, kNo, /**/ 0, 3, kNo, /**/ 0, kNo, 2});
  EXPECT_EQ(regions(options(), tensors), (Numbers{30, 40, 40, 20})) << "one by default";
  EXPECT_EQ(regions(options("2"), tensors), (Numbers{30, 40, 40, 20, 50, 70, 40, 20}));
}

TEST(TensorRegion, ReadsQuantisedOutputsAsTheModelMeansThem) {
  // 0.1 * (value - 100): the boxes are 0; the logits 0, 3, 2 and -9.
  const std::vector<TestTensor> tensors{
      {ElementType::UInt8, "4:1:3", Bytes(12, 100)},
      {ElementType::UInt8, "3:3", Bytes{100, 10, 10, /**/ 100, 130, 10, /**/ 100, 10, 120}}};
  TestDecoder decoder(kMode, options("2"));
  decoder.set_model(tensors, 0.1f, 100);
  ASSERT_TRUE(decoder.configure(tensors)) << decoder.error;
  const Bytes read = decoder.decode(tensors);
  EXPECT_EQ(read, decoded(options("2"), anchors({0, kNo, kNo, /**/ 0, 3, kNo, /**/ 0, kNo, 2})));
  EXPECT_NE(read, decoded(options("2"), tensors)) << "without a model they are plain numbers";
}

TEST(TensorRegion, FillsUnusedRegionsWithZeros) {
  EXPECT_EQ(regions(options("3"), anchors({0, kNo, kNo, /**/ 0, 3, kNo, /**/ 0, kNo, kNo})),
            (Numbers{30, 40, 40, 20, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(regions(options("2"), anchors(std::vector<float>(9, kNo))), Numbers(8));
}

TEST(TensorRegion, WritesAFlexibleTensor) {
  TestDecoder decoder(kMode, options("2"));
  const auto tensors = anchors(std::vector<float>(9, kNo));
  ASSERT_TRUE(decoder.configure(tensors)) << decoder.error;
  EXPECT_EQ(decoder.caps, "other/tensors,format=(string)flexible");
  const Bytes& bytes = decoder.decode(tensors);
  ASSERT_EQ(bytes.size(), 128u + 2 * 16);
  const auto header = read_tensor_chunk(std::as_bytes(std::span(bytes)));
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->spec.to_string(), "uint32 4:2");
  EXPECT_EQ(header->format, Format::Static) << "as NNStreamer writes it";
}

// The best class would rank anchor 0 first, the first class ranks it last.
TEST(TensorRegion, TakesTheFirstClassOverTheThreshold) {
  const auto tensors = anchors({0, 1, 9, /**/ 0, 3, kNo, /**/ 0, kNo, 2});
  EXPECT_EQ(regions(options("3"), tensors),
            (Numbers{30, 40, 40, 20, 50, 70, 40, 20, 10, 10, 40, 20}));
}

TEST(TensorRegion, RemovesOverlappingRegions) {
  // Anchor 0 is moved to anchor 1: (0.5 - 0.2) / 0.2 * 10 = 15 and (0.5 - 0.3) / 0.4 * 10 = 5.
  const std::vector<float> boxes{15, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const auto tensors = anchors({0, 2, kNo, /**/ 0, 3, kNo, /**/ 0, kNo, kNo}, boxes);
  EXPECT_EQ(regions(options("2"), tensors), (Numbers{30, 40, 40, 20, 0, 0, 0, 0}));
  const auto keeping = regions(options("2", "100:100", priors() + "::::::1.5"), tensors);
  EXPECT_NE(keeping[6], 0u) << "a threshold that no overlap exceeds";
}

TEST(TensorRegion, HasAModelInputOf300By300ByDefault) {
  const auto tensors = anchors({0, kNo, kNo, /**/ 0, 3, kNo, /**/ 0, kNo, kNo});
  EXPECT_EQ(regions(options("1", ""), tensors), regions(options("1", "300:300"), tensors));
  EXPECT_EQ(regions(options("1", ""), tensors), (Numbers{90, 120, 120, 60}));
}

TEST(TensorRegion, LeavesOutWhatIsNotFinite) {
  for (const float odd : {NAN, INFINITY}) {
    const auto tensors = anchors({0, 5, kNo, /**/ 0, 3, kNo, /**/ 0, NAN, kNo},
                                 {odd, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(regions(options("2"), tensors), (Numbers{30, 40, 40, 20, 0, 0, 0, 0})) << odd;
  }
}

TEST(TensorRegion, NeedsANumberOfRegions) {
  for (const char* number : {"0", "2035"}) {
    const auto error = error_of(kMode, options(number), {});
    EXPECT_SAYS(error, "WEIR-1004: option1 is not a number of regions");
    EXPECT_SAYS(error, std::string("offered: option1=") + number);
    EXPECT_SAYS(error, "needed: a whole number from 1 to 2034");
  }
  for (const char* number : {"-1", "1.5", "all"})
    EXPECT_SAYS(error_of(kMode, options(number), {}),
                "WEIR-1001: option1 is not a number of regions");
}

TEST(TensorRegion, NeedsALabelFile) {
  const auto none = error_of(kMode, {{"option3", priors()}}, {});
  EXPECT_SAYS(none, "WEIR-4001: mode=tensor_region has no label file");
  EXPECT_SAYS(none, "fix: option2=/path/to/labels.txt");
  const auto missing =
      error_of(kMode, {{"option2", "/nowhere/labels.txt"}, {"option3", priors()}}, {});
  EXPECT_SAYS(missing, "WEIR-4001");
  EXPECT_SAYS(missing, "No such file or directory");
  const auto fewer = error_of(kMode, {{"option2", labels("a\nb\n")}, {"option3", priors()}},
                              anchors(std::vector<float>(9)));
  EXPECT_SAYS(fewer, "WEIR-4002: the label file does not fit the model's classes");
  EXPECT_SAYS(fewer, "offered: 2 labels");
}

TEST(TensorRegion, NeedsPriorBoxes) {
  const auto none = error_of(kMode, {{"option2", labels()}}, {});
  EXPECT_SAYS(none, "WEIR-4001: mode=tensor_region needs a file of prior boxes");
  EXPECT_SAYS(none, "fix: option3=/path/to/box_priors.txt");
  EXPECT_SAYS(error_of(kMode, options("", "", "/nowhere/priors.txt"), {}),
              "No such file or directory");
  EXPECT_SAYS(error_of(kMode, options("", "", priors() + ":high"), {}),
              "a parameter of mode=tensor_region is not a number");
}

TEST(TensorRegion, NeedsASizeOfTheInput) {
  for (const char* size : {"0:300", "300:0"})
    EXPECT_SAYS(error_of(kMode, options("", size), {}), std::string("offered: option4=") + size);
  EXPECT_SAYS(error_of(kMode, options("", "300"), {}), "WEIR-1001: option4 is not a size");
}

TEST(TensorRegion, RejectsOtherTensors) {
  const auto one = error_of(kMode, options(), {{"4:1:3", std::vector<float>(12)}});
  EXPECT_SAYS(one, "WEIR-2001: mode=tensor_region does not accept these tensors");
  EXPECT_SAYS(one, "offered: 1 tensor: float32 4:1:3");
  EXPECT_SAYS(error_of(kMode, options(),
                       {{"5:1:3", std::vector<float>(15)}, {"3:3", std::vector<float>(9)}}),
              "needed: 2 tensors of one type: boxes 4:1:N and scores CLASSES:N");
  TestDecoder decoder(kMode, options());
  decoder.decode({});
  EXPECT_SAYS(decoder.error, "offered: 0 tensors");
}

}  // namespace tensor_region_test
}  // namespace weir::decoders
