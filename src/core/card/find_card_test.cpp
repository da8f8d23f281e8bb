// Finds the card of a model, and reports when there is none.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/find_card.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/card/metadata.hpp"
#include "says.hpp"

namespace weir::card {
namespace find_card_test {

namespace fs = std::filesystem;

const std::string kDigest(64, 'a'), kOther(64, 'b');

class FindCard : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "cards");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& file, const std::string& digest, const std::string& name) {
    const nlohmann::json card{
        {"name", name},
        {"model", "net.onnx"},
        {"sha256", digest},
        {"inputs",
         {{{"type", "uint8"}, {"shape", {1, 8, 8, 3}}, {"layout", "NHWC"}, {"color", "RGB"}}}},
        {"labels", {{"file", "labels.txt"}, {"skip", 1}}},
        {"provenance", nlohmann::json::object()}};
    std::ofstream(folder_ / file) << card.dump();
  }
  Search search() {
    Search out;
    out.model = (folder_ / "net.onnx").string();
    out.sha256 = [] { return kDigest; };
    out.folders = {(folder_ / "cards").string()};
    ImageInput input;
    input.name = "x";
    input.type = ElementType::Float32;
    input.shape = {1, 3, 32, 32};
    input.layout = Layout::Nchw;
    out.inputs = {input};
    return out;
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "weir-find-card-test";
};

TEST_F(FindCard, PrefersTheCardBesideTheModel) {
  write("net.card.json", kDigest, "beside");
  write("cards/other.card.json", kDigest, "by digest");
  const auto card = find(search());
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->name, "beside");
}

TEST_F(FindCard, FindsTheCardWithTheModelsDigest) {
  write("cards/a.card.json", kOther, "another");
  write("cards/b.card.json", kDigest, "by digest");
  const auto card = find(search());
  ASSERT_TRUE(card) << card.error().message();
  EXPECT_EQ(card->name, "by digest");
}

TEST_F(FindCard, UsesTheModelsMetadata) {
  Search wanted = search();
  wanted.from_model = wanted.inputs;
  const auto card = find(wanted);
  ASSERT_TRUE(card);
  EXPECT_EQ(card->inputs[0].width(), 32);
}

TEST_F(FindCard, RejectsACardOfADifferentFile) {
  write("net.card.json", kOther, "beside");
  const auto card = find(search());
  ASSERT_FALSE(card);
  EXPECT_EQ(card.error().code, Code::CARD_INVALID);
  EXPECT_SAYS(card.error().message(), kOther);
  EXPECT_SAYS(card.error().message(), kDigest);
}

TEST_F(FindCard, DoesNotSkipADamagedCard) {
  std::ofstream(folder_ / "cards/a.card.json") << "{";
  write("cards/b.card.json", kDigest, "by digest");
  const auto card = find(search());
  ASSERT_FALSE(card);
  EXPECT_SAYS(card.error().message(), "a.card.json");
}

TEST_F(FindCard, OffersACardTemplate) {
  const auto card = find(search());
  ASSERT_FALSE(card);
  EXPECT_EQ(card.error().code, Code::CARD_MISSING);
  const std::string& fix = card.error().fix;
  const auto given = nlohmann::json::parse(fix.substr(fix.find('{')));
  EXPECT_EQ(given["sha256"], kDigest);
  EXPECT_EQ(given["inputs"][0]["shape"], nlohmann::json({1, 3, 32, 32}));
  EXPECT_EQ(given["inputs"][0]["layout"], "NCHW");
  EXPECT_FALSE(parse(given.dump(), "as it is")) << "what is to be filled in is no card yet";
}

TEST_F(FindCard, ReadsLabelsBesideTheModel) {
  write("net.card.json", kDigest, "beside");
  const auto card = find(search());
  ASSERT_TRUE(card);
  const auto none = read_labels(*card, search().model, {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Code::LABELS_INVALID);
  EXPECT_SAYS(none.error().message(), "labels.txt");
  std::ofstream(folder_ / "labels.txt") << "background\ncat\r\ndog\n";
  const auto labels = read_labels(*card, search().model, {});
  ASSERT_TRUE(labels);
  EXPECT_EQ(*labels, (std::vector<std::string>{"cat", "dog"}));
  fs::resize_file(folder_ / "labels.txt", (size_t{16} << 20) + 1);
  const auto too_large = read_labels(*card, search().model, {});
  ASSERT_FALSE(too_large);
  EXPECT_SAYS(too_large.error().message(), "the label file that the card names is too large");
  EXPECT_SAYS(too_large.error().message(), (folder_ / "labels.txt").string());
}

// ONNX, docs/MetadataProps.md: the category Image.
TEST_F(FindCard, ReadsTheMetadataOfOnnxModels) {
  const ImageInput input = search().inputs[0];
  using Properties = std::map<std::string, std::string>;
  const auto normalized = input_from_metadata(
      {{"Image.BitmapPixelFormat", "Bgr8"}, {"Image.NominalPixelRange", "Normalized_1_1"}}, input);
  ASSERT_TRUE(normalized);
  EXPECT_EQ(normalized->color, Color::Bgr);
  EXPECT_EQ(normalized->layout, Layout::Nchw);
  EXPECT_NEAR((0 - normalized->mean[0]) * normalized->scale[0], -1, 1e-12);
  EXPECT_NEAR((255 - normalized->mean[0]) * normalized->scale[0], 1, 1e-12);
  const auto plain = input_from_metadata({{"Image.BitmapPixelFormat", "Rgb8"}}, input);
  ASSERT_TRUE(plain);
  EXPECT_TRUE(plain->mean.empty() && plain->scale.empty());
  for (const auto& nothing :
       {Properties{}, Properties{{"Image.BitmapPixelFormat", "Rgb16"}},
        Properties{{"Image.BitmapPixelFormat", "Gray8"}},  // the input has three channels
        Properties{{"Image.BitmapPixelFormat", "Rgb8"},
                   {"Image.NominalPixelRange", "NominalRange_16_235"}}})
    EXPECT_FALSE(input_from_metadata(nothing, input));
}

TEST_F(FindCard, ReadsTheMetadataOfTensorflowLiteModels) {
  ImageInput input = search().inputs[0];
  std::map<std::string, std::string> properties{
      {"tflite.color_space", "RGB"}, {"tflite.mean", "127.5"}, {"tflite.std", "64"}};
  const auto real = input_from_metadata(properties, input);
  ASSERT_TRUE(real);
  EXPECT_EQ(real->mean, std::vector<double>{127.5});
  EXPECT_EQ(real->scale, std::vector<double>{1.0 / 64});
  input.type = ElementType::UInt8;
  const auto bytes = input_from_metadata(properties, input);
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(bytes->mean.empty()) << "quantised: the pixels as they are";
  input.type = ElementType::Int8;
  EXPECT_EQ(input_from_metadata(properties, input)->mean, std::vector<double>{128});
  input.type = ElementType::Float32;
  for (const auto& [key, value] :
       std::vector<std::pair<const char*, const char*>>{{"tflite.std", "0"},
                                                        {"tflite.std", "x"},
                                                        {"tflite.mean", "1,2"},
                                                        {"tflite.color_space", "GRAYSCALE"}}) {
    auto wrong = properties;
    wrong[key] = value;
    EXPECT_FALSE(input_from_metadata(wrong, input)) << key << " " << value;
  }
}

TEST_F(FindCard, ReadsTheLabelsOfTensorflowLiteModels) {
  EXPECT_EQ(labels_from_metadata({{"tflite.labels", "cat\r\n\ndog\n"}}),
            (std::vector<std::string>{"cat", "", "dog"}));
  EXPECT_TRUE(labels_from_metadata({}).empty());
  Search wanted = search();
  wanted.from_model = wanted.inputs;
  wanted.labels_from_model = {"cat"};
  const auto card = find(wanted);
  ASSERT_TRUE(card);
  EXPECT_EQ(card->decoder, "image_labeling");
}

TEST_F(FindCard, ReadsLargeFilesForCardsWithTheirNameOnly) {
  write("cards/a.card.json", kDigest, "by digest");
  std::ofstream(folder_ / "cards/labels.txt") << "title\ncat\n";
  int reads = 0;
  const auto labels_of = [&](const char* file, uintmax_t bytes) {
    std::ofstream(folder_ / file) << "";
    fs::resize_file(folder_ / file, bytes);
    reads = 0;
    return find_labels(
        folder_ / file, [](const ImageInput&) { return true; }, [&] { return ++reads, kDigest; },
        {(folder_ / "cards").string()});
  };
  const std::vector<std::string> cat{"cat"};
  EXPECT_EQ(labels_of("copy.onnx", 1 << 20), cat);
  EXPECT_EQ(reads, 1);
  EXPECT_TRUE(labels_of("copy.onnx", uintmax_t{65} << 20).empty());
  EXPECT_EQ(reads, 0);
  EXPECT_EQ(labels_of("net.onnx", uintmax_t{65} << 20), cat);
  EXPECT_EQ(reads, 1);
}

}  // namespace find_card_test
}  // namespace weir::card
