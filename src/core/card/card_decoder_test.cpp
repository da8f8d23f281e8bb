// Which modes, options and files a card may name, and the texts of the errors for others.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/card/card.hpp"
#include "core/card/decoder_modes.hpp"
#include "says.hpp"

namespace weir::card {
namespace card_decoder_test {

using Json = nlohmann::json;
using Options = std::vector<std::pair<std::string, std::string>>;

Json card_with(const Json& decoder, const Json& options = nullptr) {
  Json json = Json::parse(R"({
    "name": "net", "model": "net.onnx",
    "sha256": "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
    "inputs": [{"name": "x", "type": "float32", "shape": [1, 224, 224, 3], "layout": "NHWC",
                "color": "RGB"}],
    "provenance": {"source": "here"}})");
  json["decoder"] = decoder;
  json["decoder_options"] = options;
  return json;
}
Result<Card> parsed(const Json& decoder, const Json& options = nullptr,
                    const std::string& folder = "/models") {
  return parse(card_with(decoder, options).dump(), "net.card.json", folder);
}
std::string error_of(const Json& decoder, const Json& options = nullptr,
                     const std::string& folder = "/models") {
  const auto card = parsed(decoder, options, folder);
  if (card) return "accepted";
  EXPECT_EQ(card.error().code, Code::CARD_INVALID);
  return card.error().message();
}
Options options_of(const Json& decoder, const Json& options) {
  const auto card = parsed(decoder, options);
  if (!card) ADD_FAILURE() << card.error().message();
  return card ? card->decoder_options : Options();
}

TEST(CardDecoder, IsAnyModeThatComesWithWeir) {
  for (const DecoderMode& mode : decoder_modes()) {
    const auto card = parsed(mode.name);
    ASSERT_TRUE(card) << card.error().message();
    EXPECT_EQ(card->decoder, mode.name);
  }
}

TEST(CardDecoder, RunsNoCode) {
  for (const char* mode : {"python3", "Python3", "custom-code"}) {
    const std::string error = error_of(mode, {{"option1", "/tmp/d.py"}});
    EXPECT_SAYS(error, "net.card.json/decoder: \"" + std::string(mode) + "\"");
    EXPECT_SAYS(error, "needed: a mode that runs no code: image_labeling, detection,");
    EXPECT_EQ(error.find("decoder_options"), std::string::npos) << error;
  }
  EXPECT_SAYS(
      error_of("python3"),
      "to run your own, write tensor_decoder mode=python3 option1=/path/to/script.py into a "
      "pipeline");
}

TEST(CardDecoder, IsOneNameAndNoPartOfAPipeline) {
  for (const char* mode :
       {"classification ! fakesink", "classification option1=x", " classification", "detection\n",
        "my_sub_plugin", "/tmp/libweir-decoder-x.so", "../x", "Classification2 ! filesink"})
    EXPECT_SAYS(error_of(mode), "net.card.json/decoder: ") << mode;
  EXPECT_SAYS(error_of("clasification"), "needed: did you mean classification?");
  EXPECT_SAYS(error_of("my_sub_plugin"), "needed: null, or a mode that comes with Weir: image_lab");
}

TEST(CardDecoder, HasTheOptionsOfItsMode) {
  EXPECT_EQ(options_of("detection", {{"custom", "head:yolox, unit:cells"},
                                     {"iou", "0.5"},
                                     {"max-results", "10"},
                                     {"classes", "person,car"},
                                     {"threshold", "0.3"}}),
            (Options{{"classes", "person,car"},
                     {"custom", "head:yolox,unit:cells"},
                     {"iou", "0.5"},
                     {"max-results", "10"},
                     {"threshold", "0.3"}}));
  EXPECT_EQ(options_of("bounding_boxes", {{"option1", "yolov5"}, {"option3", "0:0.5:0.45"}}),
            (Options{{"option1", "yolov5"}, {"option3", "0:0.5:0.45"}}));
  EXPECT_TRUE(options_of("octet_stream", Json::object()).empty());
  EXPECT_TRUE(options_of(nullptr, Json::object()).empty());
}

TEST(CardDecoder, HasNoOtherOptions) {
  const std::string error = error_of("detection", {{"treshold", "0.3"}});
  EXPECT_SAYS(error, "net.card.json/decoder_options/treshold: \"0.3\"");
  EXPECT_SAYS(error,
              "needed: did you mean threshold? mode=detection has threshold, iou, labels, "
              "max-results, classes, custom");
  for (const char* name : {"config-file", "mode", "name", "option1", "silent", "head", "priors",
                           "x ! fakesink name", "custom ", "Custom", ""})
    EXPECT_SAYS(error_of("detection", {{name, "x"}}), "mode=detection has ") << name;
  for (const char* name : {"option9", "labels", "custom"})
    EXPECT_SAYS(error_of("image_labeling", {{name, "x"}}), "mode=image_labeling has option1\n");
  EXPECT_SAYS(error_of("octet_stream", {{"option1", "x"}}),
              "no option: mode=octet_stream has none");
  EXPECT_SAYS(error_of(nullptr, {{"option1", "x"}}),
              "decoder_options: {\"option1\":\"x\"}\n  needed: a decoder that has these options");
  for (const char* custom :
       {"option1:/etc/passwd", "mode:x", "config-file:/etc/passwd", "hed:yolox"})
    EXPECT_SAYS(error_of("detection", {{"custom", custom}}), "mode=detection has threshold, iou")
        << custom;
  EXPECT_SAYS(error_of("detection", {{"custom", "hed:yolox"}}), "did you mean head?");
  EXPECT_SAYS(error_of("detection", {{"custom", "head"}}),
              "key:value for each option, with commas");
}

TEST(CardDecoder, NumbersOfOptionsAreNumbers) {
  for (const char* value : {"nan", "inf", "-0.1", "1.1", "1e300", "0.5 ! x", "half", "0,5"}) {
    EXPECT_SAYS(error_of("detection", {{"threshold", value}}), "a number from 0 to 1, as text");
    EXPECT_SAYS(error_of("detection", {{"custom", "iou:" + std::string(value)}}), "needed: ");
  }
  for (const char* value : {"-1", "65537", "1.5", "99999999999999999999", "x"})
    EXPECT_SAYS(error_of("detection", {{"max-results", value}}), "a whole number from 0 to 65536");
}

TEST(CardDecoder, FilesLieBesideTheCard) {
  EXPECT_EQ(
      options_of("detection", {{"labels", "my labels.txt"}, {"custom", "head:ssd,priors:p.txt"}}),
      (Options{{"custom", "head:ssd,priors:/models/p.txt"}, {"labels", "/models/my labels.txt"}}));
  EXPECT_EQ(options_of("image_labeling", {{"option1", "l.txt"}}),
            (Options{{"option1", "/models/l.txt"}}));
  EXPECT_EQ(options_of("tensor_region", {{"option2", "l.txt"}, {"option3", "p.txt:0.5:10"}}),
            (Options{{"option2", "/models/l.txt"}, {"option3", "/models/p.txt:0.5:10"}}));
  EXPECT_EQ(options_of("bounding_boxes", {{"option1", "mobilenet-ssd"}, {"option3", "p.txt:0.5"}}),
            (Options{{"option1", "mobilenet-ssd"}, {"option3", "/models/p.txt:0.5"}}));
  EXPECT_EQ(options_of("json", {{"labels", "a.txt;b.txt"}}),
            (Options{{"labels", "/models/a.txt;/models/b.txt"}}));
}

TEST(CardDecoder, FilesLieNowhereElse) {
  for (const char* file : {"/etc/passwd", "../secret.txt", "a/b.txt", "..", ".", "./x"}) {
    EXPECT_SAYS(error_of("detection", {{"labels", file}}),
                "the name of a file beside the card, without folders; for any other file, use "
                "--labels FILE of weir try and weir evaluate");
    for (const std::string key : {"labels", "priors"})
      EXPECT_SAYS(error_of("detection", {{"custom", key + ":" + file}}), "a file beside the card");
    EXPECT_SAYS(error_of("image_labeling", {{"option1", file}}), "a file beside the card");
    EXPECT_SAYS(error_of("pose_estimation", {{"option3", file}}),
                "use tensor_decoder in a pipeline of your own");
    EXPECT_SAYS(error_of("tensor_region", {{"option3", file + std::string(":0.5")}}),
                "a file beside the card");
    for (const char* scheme : {"mobilenet-ssd", "tflite-ssd"})
      EXPECT_SAYS(error_of("bounding_boxes", {{"option1", scheme}, {"option3", file}}),
                  "a file beside the card");
    EXPECT_SAYS(error_of("json", {{"labels", "a.txt;" + std::string(file)}}), "beside the card");
  }
}

TEST(CardDecoder, FoldersCannotBecomeOptions) {
  EXPECT_SAYS(error_of("detection", {{"custom", "priors:p.txt"}}, "/a,labels:/etc"),
              "a card in a folder whose path has no \",\"");
  EXPECT_SAYS(error_of("tensor_region", {{"option3", "p.txt"}}, "/a:b"), "has no \":\"");
  EXPECT_SAYS(error_of("json", {{"labels", "l.txt"}}, "/a;b"), "has no \";\"");
}

TEST(CardDecoder, ValuesArePlainText) {
  for (const std::string& value : {std::string("a\nb"), std::string("a\0b", 3),
                                   std::string("\x1b[2J"), std::string(5000, 'a')}) {
    EXPECT_SAYS(error_of("detection", {{"classes", value}}),
                "a text of at most 4096 bytes, without control characters");
    EXPECT_SAYS(error_of("detection", {{"custom", "name:" + value}}), "without control characters");
  }
  for (const Json& value : {Json(0.3), Json(true), Json{1}, Json{{"a", 1}}, Json(nullptr)})
    EXPECT_SAYS(error_of("detection", {{"classes", value}}),
                "a string: the value of this property");
}

TEST(CardDecoder, FilesOfACardThatIsReadHaveItsFolder) {
  const std::string folder = testing::TempDir() + "weir-card-decoder";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/net.card.json") << card_with("detection", {{"labels", "l.txt"}});
  const auto card = read(folder + "/net.card.json");
  std::filesystem::remove_all(folder);
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->decoder_options, (Options{{"labels", folder + "/l.txt"}}));
}

}  // namespace card_decoder_test
}  // namespace weir::card
