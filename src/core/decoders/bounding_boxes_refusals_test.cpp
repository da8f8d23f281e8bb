// Options, files and tensors that bounding_boxes rejects, with their error texts; and numbers
// that it survives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/decoders/decoder_test_support.hpp"

namespace weir::decoders {
namespace bounding_boxes_refusals_test {

constexpr const char* kMode = "bounding_boxes";

// The options of a scheme with a label file of `labels` lines; 0: without one.
DecoderOptions options_of(const std::string& scheme, const std::string& parameters, size_t labels,
                          const std::string& input = "32:32") {
  DecoderOptions options{{"option1", scheme}, {"option4", "32:32"}, {"option5", input}};
  if (!parameters.empty()) options.emplace_back("option3", parameters);
  if (labels == 0) return options;
  std::string text;
  for (size_t i = 0; i < labels; ++i) text += "label" + std::to_string(i) + "\n";
  options.emplace_back("option2", file_with("refusals-labels.txt", text));
  return options;
}
TestTensor zeros(const std::string& shape, ElementType type = ElementType::Float32) {
  return {type, shape, Bytes(*Shape::parse(shape).count() * element_size(type))};
}
std::string error_with(DecoderOptions options, const std::string& key, const std::string& value) {
  std::erase_if(options, [&](const auto& option) { return option.first == key; });
  if (!value.empty()) options.emplace_back(key, value);
  return TestDecoder(kMode, options).error;
}
const DecoderOptions& good() {
  static const DecoderOptions options = options_of("yolov8", "", 2);
  return options;
}
std::string priors(size_t anchors) {
  std::string text;
  for (int line = 0; line < 4; ++line) {
    for (size_t i = 0; i < anchors; ++i) text += "0.5 ";
    text += "\n";
  }
  return file_with("priors.txt", text);
}

TEST(BoundingBoxesRefusals, AnUnknownSchemeNamesTheNearest) {
  const std::string error = error_with(good(), "option1", "yolo8");
  EXPECT_SAYS(error, "WEIR-1004: mode=bounding_boxes has no such scheme");
  EXPECT_SAYS(error, "offered: option1=yolo8");
  EXPECT_SAYS(error,
              "needed: one of: mobilenet-ssd, mobilenet-ssd-postprocess, ov-person-detection, "
              "ov-face-detection, yolov5, yolov8, yolov8-obb, yolov10, mp-palm-detection");
  EXPECT_SAYS(error, "did you mean yolov8?");
  EXPECT_SAYS(error, "fix: option1=yolov8");
  EXPECT_SAYS(error_with(good(), "option1", ""), "mode=bounding_boxes needs the scheme");
  EXPECT_SAYS(error_with(good(), "option1", "YOLOV8"), "WEIR-1004");
}

TEST(BoundingBoxesRefusals, SizesMustBeSizes) {
  for (const char* option : {"option4", "option5"}) {
    EXPECT_SAYS(error_with(good(), option, ""),
                std::string("WEIR-1004: ") + option + " is required");
    for (const char* text : {"640", "640:480:3", "640x480", ":", "a:b", "-1:5", "640:", "1.5:2"}) {
      const std::string error = error_with(good(), option, text);
      EXPECT_SAYS(error, std::string("WEIR-1001: ") + option + " is not a size");
      EXPECT_SAYS(error, std::string("offered: ") + option + "=" + text);
      EXPECT_SAYS(error, std::string("fix: ") + option + "=640:480");
    }
    for (const char* text : {"0:480", "640:0", "40000:2", "99999999999:1"})
      EXPECT_SAYS(error_with(good(), option, text), "is a size that cannot be used");
  }
}

TEST(BoundingBoxesRefusals, SwitchesAreOnOrOff) {
  for (const char* option : {"option6", "option7"}) {
    const std::string error = error_with(good(), option, "yes");
    EXPECT_SAYS(error, std::string("WEIR-1004: ") + option + " is neither on nor off");
    EXPECT_SAYS(error, std::string("fix: ") + option + "=1");
    for (const char* text : {"0", "1", ""}) EXPECT_EQ(error_with(good(), option, text), "");
  }
  EXPECT_EQ(error_with(good(), "option8", "anything"), "") << "ignored";
}

TEST(BoundingBoxesRefusals, LabelFilesMustBeReadable) {
  const std::string missing = error_with(good(), "option2", "/nowhere/labels.txt");
  EXPECT_SAYS(missing, "WEIR-4001: the label file cannot be read: No such file or directory");
  EXPECT_SAYS(missing, "offered: option2=/nowhere/labels.txt");
  EXPECT_SAYS(error_with(good(), "option2", testing::TempDir()),
              "WEIR-4001: the label file cannot be read: Is a directory");
  EXPECT_SAYS(error_with(good(), "option2", "/dev/null"),
              "WEIR-4001: the label file cannot be read: not a regular file");
  EXPECT_SAYS(error_with(good(), "option2", file_with("empty.txt", "")), "WEIR-4002");
}

TEST(BoundingBoxesRefusals, PriorFilesMustBeReadable) {
  const auto error = [](const std::string& parameters) {
    return TestDecoder(kMode, options_of("mobilenet-ssd", parameters, 2)).error;
  };
  EXPECT_SAYS(error(""), "WEIR-4001: option1=mobilenet-ssd needs a file of prior boxes");
  EXPECT_SAYS(error(":0.5"), "offered: option3=:0.5");
  EXPECT_SAYS(error("/nowhere/priors.txt"),
              "WEIR-4001: the file of option3 cannot be read: No such file or directory");
  EXPECT_SAYS(error("/nowhere/priors.txt"), "offered: /nowhere/priors.txt");
  EXPECT_SAYS(error(testing::TempDir()), "cannot be read: Is a directory");
  if (geteuid() != 0) {
    const std::string secret = file_with("secret.txt", "1");
    std::filesystem::permissions(secret, std::filesystem::perms::none);
    EXPECT_SAYS(error(secret), "cannot be read: Permission denied");
    std::filesystem::permissions(secret, std::filesystem::perms::owner_all);
  }
  EXPECT_SAYS(error(file_with("bad.txt", "1 2\n3 4\n5 6\n7\n")),
              "line 4 (widths) has 1 values, the first line 2");
  EXPECT_SAYS(error(file_with("empty.txt", "")),
              "WEIR-1001: the file is not a list of prior boxes");
  EXPECT_SAYS(error(file_with("long.txt", std::string((16 << 20) + 1, ' '))), "it is too long");
}

TEST(BoundingBoxesRefusals, ParametersMustBeNumbers) {
  const std::pair<const char*, std::string> wrong[] = {{"mobilenet-ssd", priors(2) + ":x"},
                                                       {"yolov5", "0:x"},
                                                       {"yolov8", "0:0.5:nan"},
                                                       {"yolov8-obb", "0:inf"},
                                                       {"yolov10", "0:1e99"},
                                                       {"mp-palm-detection", "x"}};
  for (const auto& [scheme, parameters] : wrong) {
    const std::string error = TestDecoder(kMode, options_of(scheme, parameters, 2)).error;
    EXPECT_SAYS(error, "WEIR-1001: a parameter of option1=" + std::string(scheme));
    EXPECT_SAYS(error, "option3=" + parameters);
  }
  const std::pair<const char*, std::string> many[] = {
      {"mobilenet-ssd", priors(2) + ":::::::"},
      {"yolov5", "0:0.5:0.5:1"},
      {"yolov10", "0:0.5:1"},
      {"mp-palm-detection", "0.5:4:1:1:1:1:8:8:8:8:8:8:8:8"}};
  for (const auto& [scheme, parameters] : many)
    EXPECT_SAYS(TestDecoder(kMode, options_of(scheme, parameters, 2)).error,
                "WEIR-1001: option3 has more parameters than option1=" + std::string(scheme));
  EXPECT_SAYS(TestDecoder(kMode, options_of("mobilenet-ssd", priors(2) + ":0.5:0", 2)).error,
              "WEIR-1004: the y scale of option3 is 0");
}

TEST(BoundingBoxesRefusals, PostprocessNeedsFourIndicesAndAThreshold) {
  for (const char* text : {"0:1:2:3", "0:1:2,50", "0:1:2:2,50", "0:1:2:4,50", "0:1:2:3,", ",50",
                           "0:1:2:-1,50", "0:1:2:3,50,1"}) {
    const std::string error =
        TestDecoder(kMode, options_of("mobilenet-ssd-postprocess", text, 0)).error;
    EXPECT_SAYS(error, "WEIR-1001: option3 is not what option1=mobilenet-ssd-postprocess takes");
    EXPECT_SAYS(error, std::string("offered: option3=") + text);
    EXPECT_SAYS(error, "fix: option3=0:1:2:3,50");
  }
  for (const char* text : {"0:1:2:3,50", "3:2:1:0,0", " 0 : 1 : 2 : 3 , 50% "})
    EXPECT_EQ(TestDecoder(kMode, options_of("mobilenet-ssd-postprocess", text, 0)).error, "");
}

// As NNStreamer: such a pipeline goes on with the default threshold.
TEST(BoundingBoxesRefusals, AThresholdBeyondAHundredPercentIsLogged) {
  const LogLines log;
  EXPECT_EQ(TestDecoder(kMode, options_of("mobilenet-ssd-postprocess", "0:1:2:3,101", 0)).error,
            "");
  EXPECT_EQ(LogLines::lines, std::vector<std::string>{
                                 "1 bounding_boxes: the threshold of option3=0:1:2:3,101 is not "
                                 "from 0 to 100 percent and has no effect"});
}

TEST(BoundingBoxesRefusals, PalmLayersNeedStrides) {
  for (const char* text : {"0.5:8", "0.5:0", "0.5:5", "0.5:4:1:1:0.5:0.5:0:16:16:16",
                           "0.5:1:1:1:0.5:0.5:193", "0.5:x", "0.5:1.5"}) {
    const std::string error = TestDecoder(kMode, options_of("mp-palm-detection", text, 0)).error;
    EXPECT_SAYS(error, "WEIR-1004: a ");
    EXPECT_SAYS(error, std::string("option3=") + text);
  }
}

TEST(BoundingBoxesRefusals, LabelsMustFitTheClasses) {
  const auto error = [](const std::string& scheme, size_t labels, const std::string& shape) {
    return error_of(kMode, options_of(scheme, "", labels), {zeros(shape)});
  };
  const std::string none = error("yolov8", 0, "6:21");
  EXPECT_SAYS(none, "WEIR-4002: option1=yolov8 needs a label file");
  EXPECT_SAYS(none, "needed: 2 labels for the tensor float32 6:21");
  const std::string few = error("yolov8", 3, "8:21");
  EXPECT_SAYS(few, "WEIR-4002: the label file does not fit the model's classes");
  EXPECT_SAYS(few, "offered: 3 labels");
  EXPECT_SAYS(few, "needed: 4 labels");
  EXPECT_SAYS(error("yolov8", 5, "8:21"), "WEIR-4002");
  EXPECT_SAYS(error("yolov5", 3, "9:63"), "needed: 4 labels for the tensor float32 9:63");
  EXPECT_SAYS(error("yolov8-obb", 3, "9:21"), "needed: 4 labels");
  EXPECT_EQ(error("yolov8-obb", 4, "9:21"), "");
  const std::string ssd =
      error_of(kMode, options_of("mobilenet-ssd", priors(2), 3), {zeros("4:1:2"), zeros("4:2")});
  EXPECT_SAYS(ssd, "needed: at least 4 labels for the tensor float32 4:2");
  EXPECT_EQ(
      error_of(kMode, options_of("mobilenet-ssd", priors(2), 5), {zeros("4:1:2"), zeros("4:2")}),
      "")
      << "more labels than classes";
}

struct Head {
  const char* scheme;
  std::string parameters;
  size_t labels;
  std::vector<TestTensor> good;
};
std::vector<Head> heads() {
  return {{"mobilenet-ssd", priors(2), 3, {zeros("4:1:2"), zeros("3:2")}},
          {"mobilenet-ssd-postprocess",
           "0:1:2:3,50",
           0,
           {zeros("4:5"), zeros("5"), zeros("5"), zeros("1")}},
          {"ov-person-detection", "", 0, {zeros("7:200")}},
          {"ov-face-detection", "", 0, {zeros("7:200")}},
          {"yolov5", "", 2, {zeros("7:63")}},
          {"yolov8", "", 2, {zeros("6:21")}},
          {"yolov8-obb", "", 2, {zeros("7:21")}},
          {"yolov10", "", 0, {zeros("6:300")}},
          {"mp-palm-detection", "", 0, {zeros("18:2016"), zeros("1:2016")}}};
}

TEST(BoundingBoxesRefusals, OtherTensorsAreNamed) {
  for (const Head& head : heads()) {
    const auto options = options_of(head.scheme, head.parameters, head.labels);
    const auto error = [&](const std::vector<TestTensor>& tensors) {
      return error_of(kMode, options, tensors);
    };
    const std::string what =
        "WEIR-2001: option1=" + std::string(head.scheme) + " does not accept these tensors";
    EXPECT_EQ(error(head.good), "") << head.scheme;
    EXPECT_SAYS(TestDecoder(kMode, options).error, "");
    auto fewer = head.good, more = head.good, mixed = head.good;
    fewer.pop_back();
    more.push_back(zeros("4"));
    if (!fewer.empty()) {
      EXPECT_SAYS(error(fewer), what);
    }
    EXPECT_SAYS(error(more), what);
    EXPECT_SAYS(error(more), "offered: " + std::to_string(more.size()) + " tensors: float32 ");
    if (mixed.size() > 1) {
      mixed[0] = zeros(mixed[0].shape, ElementType::Float64);
      EXPECT_SAYS(error(mixed), what);
    }
    for (size_t i = 0; i < head.good.size(); ++i)
      for (const char* shape : {"1:1:1:7", "3:3", "18:3000", "7"}) {
        auto other = head.good;
        if (other[i].shape == shape) continue;
        other[i] = zeros(shape);
        EXPECT_SAYS(error(other), what) << i << " " << shape;
      }
  }
}

TEST(BoundingBoxesRefusals, AFrameWithoutTensorsIsAnError) {
  for (const Head& head : heads()) {
    TestDecoder decoder(kMode, options_of(head.scheme, head.parameters, head.labels));
    decoder.decode({});
    EXPECT_SAYS(decoder.error, "offered: 0 tensors");
  }
}

TEST(BoundingBoxesRefusals, YoloTakesFloat32) {
  for (const auto& [scheme, shape] :
       {std::pair{"yolov5", "7:63"}, {"yolov8", "6:21"}, {"yolov10", "6:300"}})
    EXPECT_SAYS(error_of(kMode, options_of(scheme, "", 2), {zeros(shape, ElementType::UInt8)}),
                "fix: tensor_transform mode=typecast option=float32");
}

TEST(BoundingBoxesRefusals, AYoloV8HeadOfColumnsNeedsATranspose) {
  EXPECT_SAYS(error_of(kMode, options_of("yolov8", "", 2), {zeros("21:6")}),
              "fix: tensor_transform mode=transpose option=1:0:2:3");
}

TEST(BoundingBoxesRefusals, MoreAnchorsThanPriorsAreAnError) {
  EXPECT_SAYS(
      error_of(kMode, options_of("mobilenet-ssd", priors(2), 3), {zeros("4:1:3"), zeros("3:3")}),
      "at most as many anchors as the file of option3 has prior boxes: 2");
  EXPECT_SAYS(error_of(kMode, options_of("mobilenet-ssd", priors(2035), 3),
                       {zeros("4:1:2035"), zeros("3:2035")}),
              "with N up to 2034");
}

TEST(BoundingBoxesRefusals, AFrameOfTheWrongSizeIsAnError) {
  TestTensor tensor = zeros("6:300");
  tensor.bytes.pop_back();
  TestDecoder decoder(kMode, options_of("yolov10", "", 0));
  decoder.decode({tensor});
  EXPECT_SAYS(decoder.error, "WEIR-2004: the frame does not have the size of its shape");
  EXPECT_SAYS(decoder.error, "offered: 7199 bytes");
}

// Every scheme, with each number of its tensors replaced by those that are none.
TEST(BoundingBoxesRefusals, NumbersThatAreNotFiniteDrawNothing) {
  for (const Head& head : heads())
    for (const float bad : {std::nanf(""), INFINITY, -INFINITY}) {
      std::vector<TestTensor> tensors;
      for (const TestTensor& tensor : head.good)
        tensors.push_back({tensor.shape, std::vector<float>(tensor.bytes.size() / 4, bad)});
      TestDecoder decoder(kMode, options_of(head.scheme, head.parameters, head.labels));
      EXPECT_EQ(decoder.decode(tensors), Bytes(32 * 32 * 4)) << head.scheme << " " << bad;
      EXPECT_EQ(decoder.error, "");
    }
}

TEST(BoundingBoxesRefusals, TheGreatestNumbersAreSurvived) {
  for (const Head& head : heads())
    for (const float far : {3e38f, -3e38f, 1e9f, -1e9f}) {
      std::vector<TestTensor> tensors;
      for (const TestTensor& tensor : head.good)
        tensors.push_back({tensor.shape, std::vector<float>(tensor.bytes.size() / 4, far)});
      TestDecoder decoder(kMode, options_of(head.scheme, head.parameters, head.labels));
      EXPECT_EQ(decoder.decode(tensors).size(), 32u * 32 * 4) << decoder.error;
    }
}

// 100,800 candidates that do not overlap, which is the most work for the suppression, and as many
// at the same place.
TEST(BoundingBoxesRefusals, AHundredThousandCandidatesAreDrawn) {
  constexpr size_t kRows = 100'800, kLength = 6;
  DecoderOptions options = options_of("yolov5", "1:0.25:0.45", 1, "1280:1280");
  TestDecoder decoder(kMode, options);
  std::vector<float> rows(kRows * kLength);
  for (size_t i = 0; i < kRows; ++i) {
    const std::array<float, kLength> row{float(i % 320 * 4), float(i / 320 * 4), 2, 2, 1, 1};
    std::copy(row.begin(), row.end(), rows.begin() + static_cast<ptrdiff_t>(i * kLength));
  }
  decoder.decode({{"6:100800", rows}});
  EXPECT_EQ(decoder.error, "");
  EXPECT_EQ(decoder.output.size(), 32u * 32 * 4);
  EXPECT_NE(decoder.output, Bytes(32 * 32 * 4));
  for (size_t i = 0; i < kRows; ++i)
    std::fill_n(rows.begin() + static_cast<ptrdiff_t>(i * kLength), 4, 640.f);
  const LogLines log;
  options.emplace_back("option7", "1");
  TestDecoder(kMode, options).decode({{"6:100800", rows}});
  ASSERT_FALSE(LogLines::lines.empty());
  EXPECT_SAYS(LogLines::lines[0], "Detect 1 boxes in 1280 x 1280 input image");
}

}  // namespace bounding_boxes_refusals_test
}  // namespace weir::decoders
