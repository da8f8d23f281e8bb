// Parses cards, checks their pipelines, and rejects invalid cards.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/card.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "says.hpp"

namespace weir::card {
namespace card_test {

using Json = nlohmann::json;

Json good() {
  return Json::parse(R"({
    "name": "net", "model": "net.onnx", "task": "test",
    "sha256": "0123456789abcdef0123456789abcdef0123456789ABCDEF0123456789abcdef",
    "inputs": [{"name": "x", "type": "float32", "shape": [1, 224, 192, 3], "layout": "NHWC",
                "color": "RGB", "mean": [127.5], "scale": [0.5], "resize": "stretch"}],
    "outputs": [], "labels": ["a", "b"], "decoder": "image_labeling",
    "provenance": {"source": "here"}})");
}
Result<Card> parsed(const Json& json) {
  return parse(json.dump(), "test.card.json");
}
std::string error_of(const Json& json) {
  const auto card = parsed(json);
  if (card) return "";
  EXPECT_EQ(card.error().code, Code::CARD_INVALID);
  return card.error().message();
}
std::string prepared(const Json& input) {
  Json json = good();
  json["inputs"][0].update(input);
  const auto card = parsed(json);
  return card ? preparation(card->inputs[0]) : card.error().message();
}

TEST(Card, ReadsEachField) {
  const auto card = parsed(good());
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->name, "net");
  EXPECT_EQ(card->sha256, "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef");
  EXPECT_EQ(card->labels.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(card->decoder, "image_labeling");
  ASSERT_EQ(card->inputs.size(), 1u);
  const ImageInput& input = card->inputs[0];
  EXPECT_EQ(input.type, ElementType::Float32);
  EXPECT_EQ(input.height(), 224);
  EXPECT_EQ(input.width(), 192);
  EXPECT_EQ(input.channels(), 3);
}

TEST(Card, ReadsALetterboxAndTheDecodersOptions) {
  Json json = good();
  json["inputs"][0].update({{"resize", "letterbox"}, {"padding", 114}});
  json["decoder"] = "detection";
  json["decoder_options"] = {{"custom", "head:yolox"}, {"threshold", "0.3"}};
  const auto card = parsed(json);
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->inputs[0].resize, Fit::Letterbox);
  EXPECT_EQ(card->inputs[0].padding, 114);
  const std::vector<std::pair<std::string, std::string>> options{{"custom", "head:yolox"},
                                                                 {"threshold", "0.3"}};
  EXPECT_EQ(card->decoder_options, options);
}

TEST(Card, RefusesPaddingWithoutALetterboxAndOptionsThatAreNoTexts) {
  Json json = good();
  json["inputs"][0]["padding"] = 114;
  EXPECT_SAYS(error_of(json), "\"resize\": \"letterbox\"");
  for (const Json& padding : {Json(256), Json(-1), Json(1.5), Json("0")}) {
    json["inputs"][0].update({{"resize", "letterbox"}, {"padding", padding}});
    EXPECT_SAYS(error_of(json), "a pixel value from 0 to 255");
  }
  json = good();
  json["decoder_options"] = {{"threshold", 0.3}};
  EXPECT_SAYS(error_of(json), "decoder_options/threshold");
  json["decoder_options"] = {1, 2};
  EXPECT_SAYS(error_of(json), "decoder_options");
}

TEST(Card, NeedsNeitherLabelsNorDecoder) {
  Json json = good();
  json["decoder"] = nullptr;
  json.erase("labels");
  const auto card = parsed(json);
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->decoder, "");
  EXPECT_TRUE(card->labels.names.empty());
}

TEST(Card, NamesTheFieldThatIsMissing) {
  for (const char* key : {"name", "model", "sha256", "inputs", "provenance"}) {
    Json json = good();
    json.erase(key);
    EXPECT_SAYS(error_of(json), std::string("test.card.json/") + key + ": nothing");
  }
  for (const char* key : {"type", "shape", "layout", "color"}) {
    Json json = good();
    json["inputs"][0].erase(key);
    EXPECT_SAYS(error_of(json), std::string("test.card.json/inputs/0/") + key + ": nothing");
  }
}

TEST(Card, NamesAllFaultsAtOnce) {
  Json json = good();
  json.erase("name");
  json["sha256"] = "?";
  json["inputs"][0]["color"] = "RGB or BGR?";
  json["inputs"][0]["mean"] = {"?"};
  json["inputs"][0]["sclae"] = 1;
  EXPECT_EQ(error_of(json),
            "WEIR-3009: the model card cannot be used\n"
            "  offered: test.card.json/name: nothing\n"
            "  needed: it is required\n"
            "  first difference: 4 more errors:\n"
            "    test.card.json/sha256: \"?\", needed: 64 hexadecimal digits: sha256sum MODEL\n"
            "    test.card.json/inputs/0/sclae: 1, needed: did you mean scale?\n"
            "    test.card.json/inputs/0/color: \"RGB or BGR?\", needed: one of RGB, BGR, GRAY8\n"
            "    test.card.json/inputs/0/mean: [\"?\"], needed: a list of numbers\n"
            "  fix: docs/cards.md lists the fields of a card");
}

TEST(Card, NamesEachFaultOnce) {
  Json json = good();
  json["inputs"][0].erase("type");  // is missing, and no element type either
  EXPECT_EQ(error_of(json).find("more error"), std::string::npos) << error_of(json);
  json["inputs"][0] = 7;  // its fields are not reported
  EXPECT_EQ(error_of(json).find("more error"), std::string::npos) << error_of(json);
  json["task"] = 7;
  EXPECT_SAYS(error_of(json),
              "1 more error:\n    test.card.json/inputs/0: number, needed: an object");
}

TEST(Card, SuggestsTheNearestField) {
  Json json = good();
  json["inputs"][0]["meen"] = {1};
  EXPECT_SAYS(error_of(json), "inputs/0/meen: [1]");
  EXPECT_SAYS(error_of(json), "did you mean mean?");
}

TEST(Card, RejectsValuesOfTheWrongKind) {
  const std::pair<const char*, Json> wrong[] = {
      {"/name", 1},
      {"/name", ""},
      {"/sha256", "abc"},
      {"/sha256", std::string(64, 'x')},
      {"/inputs", Json::array()},
      {"/inputs", "x"},
      {"/inputs/0", 3},
      {"/inputs/0/type", "float23"},
      {"/inputs/0/layout", "HWCN"},
      {"/inputs/0/color", "CMYK"},
      {"/inputs/0/resize", "squeeze"},
      {"/inputs/0/mean", 1},
      {"/inputs/0/mean", {1, 2}},
      {"/inputs/0/scale", {"x"}},
      {"/inputs/0/shape", {224, 224}},
      {"/inputs/0/shape", {2, 224, 224, 3}},
      {"/inputs/0/shape", {1, 224, 224, 4}},
      {"/inputs/0/shape", {1, -1, 224, 3}},
      {"/inputs/0/shape", {1, 1e300, 224, 3}},
      {"/labels", "x"},
      {"/labels", {1, 2}},
      {"/labels", {{"file", "../../etc/passwd"}}},
      {"/labels", {{"file", "x"}, {"skip", -1}}},
      {"/decoder", 3},
      {"/provenance", "me"},
  };
  for (const auto& [place, value] : wrong) {
    Json json = good();
    json[Json::json_pointer(place)] = value;
    EXPECT_SAYS(error_of(json), place) << value;
  }
}

TEST(Card, ExtentsAreWholeNumbers) {
  for (const Json& extent : {Json(224.9), Json(0), Json(-224), Json(0.5), Json(32769), Json(1e300),
                             Json(9223372036854775807), Json(1e-300)}) {
    Json json = good();
    json["inputs"][0]["shape"][1] = extent;
    EXPECT_SAYS(error_of(json), "test.card.json/inputs/0/shape: [1," + extent.dump() + ",192,3]");
    EXPECT_SAYS(error_of(json), "needed: whole numbers from 1 to 32768");
  }
  for (const Json& extent : {Json("224"), Json(true), Json(nullptr), Json{224}}) {
    Json json = good();
    json["inputs"][0]["shape"][1] = extent;
    EXPECT_SAYS(error_of(json), "test.card.json/inputs/0/shape: ");
    EXPECT_SAYS(error_of(json), "needed: a list of numbers");
  }
  Json json = good();
  json["inputs"][0]["shape"][1] = 224.0;  // a whole number in other writing
  const auto card = parsed(json);
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->inputs[0].height(), 224);
}

TEST(Card, NumbersOfPixelsAreFinite) {
  for (const char* key : {"mean", "scale"}) {
    Json json = good();
    json["inputs"][0][key] = {1e39};
    EXPECT_SAYS(error_of(json), "numbers that fit into 32 bits, up to 3.4e38");
    json["inputs"][0][key] = {-3e38};
    EXPECT_EQ(error_of(json), "");
  }
  for (const char* number : {"NaN", "Infinity", "1e999", "-1e999"}) {
    std::string text = good().dump();
    text.replace(text.find("127.5"), 5, number);
    const auto card = parse(text, "x");
    ASSERT_FALSE(card) << number;
    EXPECT_EQ(card.error().code, Code::CARD_INVALID);
  }
}

// Texts of a card reach properties, terminals and lines to paste.
TEST(Card, TextsHaveNoControlCharacters) {
  const std::string control[] = {"a\nb", std::string("a\0b", 3), "\x1b[2J", "\x7f", "\r"};
  for (const char* place : {"/name", "/model", "/task", "/inputs/0/name", "/labels/1"})
    for (const std::string& text : control) {
      Json json = good();
      json[Json::json_pointer(place)] = text;
      const std::string error = error_of(json);
      EXPECT_SAYS(error, "test.card.json" + std::string(place) + ": ");
      EXPECT_SAYS(error, "a text of at most 4096 bytes, without control characters");
      EXPECT_EQ(error.find_first_of("\x1b\x7f\r"), std::string::npos);
    }
  for (const std::string& text : control) {
    Json json = good();
    json[text] = 1;
    EXPECT_EQ(error_of(json).find_first_of("\x1b\x7f\r"), std::string::npos);
    json = good();
    json["labels"] = {{"file", text}};
    EXPECT_SAYS(error_of(json), "test.card.json/labels/file: ");
  }
}

TEST(Card, LabelFilesHaveNamesWithoutFolders) {
  for (const char* file : {"..", ".", "/etc/passwd", "a/b", ""}) {
    Json json = good();
    json["labels"] = {{"file", file}};
    EXPECT_SAYS(error_of(json), "test.card.json/labels/file: ") << file;
  }
}

TEST(Card, RejectsOtherJson) {
  for (const char* text :
       {"", "{", "[]", "3", "{\"name\": \"\xff\"}", "null", "{} {}", "{\"name\": 1e999}"})
    EXPECT_FALSE(parse(text, "x")) << text;
  EXPECT_FALSE(parse(std::string(100000, '['), "x"));
  EXPECT_FALSE(parse(std::string((1u << 20) + 1, ' '), "x"));
  std::string deep;
  for (int i = 0; i < 20000; ++i) deep += "{\"a\":";
  const auto card = parse(deep, "x");
  ASSERT_FALSE(card);
  EXPECT_EQ(card.error().code, Code::CARD_INVALID);
}

TEST(Preparation, KeepsBytesUnchanged) {
  Json input{{"type", "uint8"}, {"mean", nullptr}, {"scale", nullptr}};
  EXPECT_EQ(
      prepared(input),
      "videoconvert ! videoscale add-borders=false ! "
      "video/x-raw,format=RGB,width=192,height=224,pixel-aspect-ratio=1/1 ! tensor_converter");
}

TEST(Preparation, SubtractsTheMeanAndMultiplies) {
  EXPECT_SAYS(prepared(Json::object()),
              "! tensor_transform mode=arithmetic option=typecast:float32,add:-127.5,mul:0.5");
}

TEST(Preparation, UsesPerChannelValuesWhereTheyDiffer) {
  EXPECT_SAYS(prepared({{"mean", {1, 2, 3}}, {"scale", {0.5}}}),
              "option=typecast:float32,per-channel:true@0,add:-1.0@0,add:-2.0@1,add:-3.0@2,"
              "mul:0.5@0,mul:0.5@1,mul:0.5@2");
  EXPECT_SAYS(prepared({{"mean", {7, 7, 7}}}), "option=typecast:float32,add:-7.0,mul:0.5");
}

TEST(Preparation, TransposesThePictureForNchw) {
  EXPECT_SAYS(prepared({{"layout", "NCHW"}, {"shape", {3, 10, 20}}}),
              "width=20,height=10,pixel-aspect-ratio=1/1 ! tensor_converter");
  EXPECT_TRUE(prepared({{"layout", "NCHW"}, {"shape", {3, 10, 20}}})
                  .ends_with(" ! tensor_transform mode=transpose option=1:2:0:3"));
}

TEST(Preparation, CastsToOtherTypes) {
  EXPECT_TRUE(prepared({{"type", "int8"}, {"mean", {128}}, {"scale", {1}}})
                  .ends_with("mul:1.0 ! tensor_transform mode=typecast option=int8"));
  EXPECT_TRUE(prepared({{"mean", nullptr}, {"scale", nullptr}})
                  .ends_with("tensor_converter ! tensor_transform mode=typecast option=float32"));
}

TEST(Preparation, CropsTheCentre) {
  EXPECT_TRUE(prepared({{"resize", "crop"}})
                  .starts_with("videoconvert ! aspectratiocrop aspect-ratio=192/224 ! videoscale"));
}

TEST(Preparation, LetterboxesByTensorPreprocess) {
  EXPECT_EQ(prepared({{"resize", "letterbox"}, {"padding", 114}}),
            "tensor_preprocess width=192 height=224 fit=letterbox padding-value=114 mean=127.5 "
            "scale=0.5 type=float32");
}

TEST(Preparation, ConvertsToGrayAndBgr) {
  EXPECT_SAYS(prepared({{"color", "BGR"}}), "format=BGR,");
  EXPECT_SAYS(prepared({{"color", "GRAY8"}, {"shape", {1, 9, 9, 1}}}), "format=GRAY8,");
}

}  // namespace card_test
}  // namespace weir::card
