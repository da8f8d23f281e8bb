// Fills requests from texts, cards and downstream tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/request.hpp"

#include <gtest/gtest.h>

#include <string>

#include "says.hpp"

namespace weir::preprocess {
namespace request_test {

template <class T>
std::string refusal(const Result<T>& result) {
  return result ? "" : result.error().message();
}

// The character position as errors report it, counted from 1; an empty text has its own message.
std::string place(const std::string& text, size_t character) {
  if (text.empty()) return "it is empty";
  return character > text.size() ? "at the end:"
                                 : "at character " + std::to_string(character) + ":";
}

TEST(Request, ReadsNumbers) {
  EXPECT_EQ(*parse_numbers("mean", "127.5"), (std::vector<double>{127.5}));
  EXPECT_EQ(*parse_numbers("mean", "1, -2.5,3e2"), (std::vector<double>{1, -2.5, 300}));
}

TEST(Request, ShowsThePlaceInNumbers) {
  for (const char* text : {"1,x,3", "1,,3", "", "1,nan,2", "1,2 3,4"}) {
    const auto words = refusal(parse_numbers("mean", text));
    EXPECT_SAYS(words, "WEIR-1001: mean cannot be read") << text;
    EXPECT_SAYS(words, place(text, 3));
  }
}

TEST(Request, ReadsAQuantisation) {
  const auto q = parse_quantisation("0.0078125:-128");
  ASSERT_TRUE(q);
  EXPECT_EQ(q->scale, 0.0078125);
  EXPECT_EQ(q->zero_point, -128);
  EXPECT_SAYS(refusal(parse_quantisation("x:1")), "at character 1");
  EXPECT_SAYS(refusal(parse_quantisation("0.5")), "at the end:");
  EXPECT_SAYS(refusal(parse_quantisation("0.5:1.5")), "at character 5");
  EXPECT_SAYS(refusal(parse_quantisation("0.5:1:2")), "needed: SCALE:ZERO_POINT");
  EXPECT_SAYS(refusal(parse_quantisation("0.5:99999999999")), "at character 5");
}

TEST(Request, ReadsSizes) {
  const std::vector<Size> two{{640, 480}, {1, 65536}};
  EXPECT_EQ(*parse_sizes("640x480,1x65536"), two);
  EXPECT_EQ(*parse_sizes(" 640 x 480 , 1x65536 "), two);
}

TEST(Request, ShowsThePlaceInSizes) {
  const struct {
    const char* text;
    size_t place;
  } cases[] = {{"", 1},        {"640", 4},
               {"640x", 5},    {"x480", 5},
               {"6x4,", 5},    {"6x4,,2x1", 5},
               {"6x4,axb", 5}, {"6x4, 3x0", 8},
               {"65537x1", 1}, {"6x4x2", 3},
               {"6x-4", 3},    {"6*4", 1},
               {"6x4,3X2", 5}, {"1x99999999999999999999", 3}};
  for (const auto& c : cases) {
    const auto words = refusal(parse_sizes(c.text));
    EXPECT_SAYS(words, "WEIR-1001: sizes cannot be read") << c.text;
    EXPECT_SAYS(words, place(c.text, c.place)) << c.text;
  }
  std::string many = "1x1";
  for (int i = 0; i < 15; ++i) many += ",1x1";
  EXPECT_EQ(parse_sizes(many)->size(), 16u);
  EXPECT_SAYS(refusal(parse_sizes(many + ",1x1")), "offered: sizes of 17 layers");
}

TEST(Request, ReadsATypeByItsName) {
  EXPECT_EQ(*parse_type("float16"), ElementType::Float16);
  EXPECT_SAYS(refusal(parse_type("float")), "WEIR-1003");
  EXPECT_SAYS(refusal(parse_type("float")), "offered: type=float");
}

card::Card card_with(std::vector<int64_t> shape, card::Layout layout, card::Color color) {
  card::ImageInput input;
  input.type = ElementType::Float32;
  input.shape = std::move(shape);
  input.layout = layout;
  input.color = color;
  input.mean = {127.5};
  input.scale = {0.5};
  input.resize = card::Fit::Crop;
  card::Card card;
  card.inputs = {input};
  return card;
}

TEST(Request, ResolvesEachLayer) {
  Request request;
  request.sizes = {{8, 6}, {4, 3}};
  const auto frames = possible_frames(request);
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[1][0].shape, (Shape{8, 6, 3, 1}));
  EXPECT_EQ(frames[1][1].shape, (Shape{4, 3, 3, 1}));
  const TensorSpec wanted[] = {{ElementType::Float32, {8, 6, 3, 1}, ""},
                               {ElementType::UInt8, {1, 4, 3, 1}, ""}};
  const auto layers = resolve_frame(request, wanted);
  ASSERT_TRUE(layers);
  EXPECT_EQ((*layers)[0].tensor().to_string(), "float32 8:6:3:1");
  EXPECT_EQ((*layers)[1].tensor().to_string(), "uint8 1:4:3:1");
  EXPECT_EQ((*resolve_frame(request, {}))[1].tensor().to_string(), "uint8 3:4:3:1");
  // A card does not replace sizes that were given.
  const auto carded =
      with_card(request, card_with({1, 5, 7, 3}, card::Layout::Nhwc, card::Color::Rgb));
  ASSERT_TRUE(carded);
  EXPECT_EQ((*resolve_frame(*carded, {}))[0].tensor().to_string(), "float32 3:8:6:1");
}

TEST(Request, ReadsEverythingFromACard) {
  const auto request =
      with_card({}, card_with({1, 3, 20, 30}, card::Layout::Nchw, card::Color::Bgr));
  ASSERT_TRUE(request);
  const auto p = resolve(*request, {});
  ASSERT_TRUE(p);
  EXPECT_EQ(p->tensor().to_string(), "float32 30:20:3:1");
  EXPECT_EQ(p->order, ChannelOrder::Bgr);
  EXPECT_EQ(p->fit, Fit::CentreCrop);
  EXPECT_EQ(p->mean, (std::vector<double>{127.5}));
  EXPECT_EQ(p->scale, (std::vector<double>{0.5}));
}

TEST(Request, UsesTheNamedInputOfACard) {
  auto card = card_with({1, 3, 20, 30}, card::Layout::Nchw, card::Color::Bgr);
  card.inputs[0].name = "left";
  card.inputs.push_back(card.inputs[0]);
  card.inputs[1].shape = {1, 3, 5, 6};
  card.inputs[1].name = "right";
  card.inputs.push_back(card.inputs[0]);
  card.inputs[2].shape = {1, 3, 7, 8};
  card.inputs[2].name = "";
  const auto size = [&](std::string_view input) {
    const auto request = with_card({}, card, input);
    return request ? request->width : 0;
  };
  EXPECT_EQ(size("left"), 30u);
  EXPECT_EQ(size("right"), 6u);
  EXPECT_EQ(size("1"), 6u);
  EXPECT_EQ(size("2"), 8u);
  card.inputs[0].name = "1";  // a name takes precedence over a number
  EXPECT_EQ(size("1"), 30u);
  const auto open = refusal(with_card({}, card));
  EXPECT_SAYS(open, "the model card does not state which input this picture is for");
  EXPECT_SAYS(open, "one of them: 0 or 1, 1 or right, 2");
  for (const char* none : {"3", "middle", "-1", "Right"}) {
    const auto text = refusal(with_card({}, card, none));
    EXPECT_SAYS(text, "the model card has no such input") << none;
    EXPECT_SAYS(text, std::string("offered: card-input=") + none);
  }
}

TEST(Request, ReadsACrop) {
  EXPECT_EQ(*parse_crop("1:2:30:40"), (Rect{1, 2, 30, 40}));
  EXPECT_EQ(*parse_crop(" 0 : 0 : 65536 : 1 "), (Rect{0, 0, 65536, 1}));
  const std::pair<const char*, size_t> odd[] = {
      {"", 1},          {"1:2:30", 7},   {"1:2:30:0", 8},    {"1:2:x:4", 5},
      {"1:2:3:4:5", 9}, {"-1:0:3:4", 1}, {"0:0:65537:1", 5}, {"0:0:4294967297:1", 5}};
  for (const auto& [text, character] : odd) {
    const auto message = refusal(parse_crop(text));
    EXPECT_SAYS(message, "crop cannot be read") << text;
    EXPECT_SAYS(message, place(text, character)) << text;
  }
}

TEST(Request, OverridesACard) {
  Request mine;
  mine.width = 8;
  mine.height = 9;
  mine.fit = Fit::Letterbox;
  mine.order = ChannelOrder::Rgb;
  mine.mean = std::vector<double>{};
  mine.scale = std::vector<double>{2};
  mine.type = ElementType::UInt8;
  mine.layout = Layout::Nhwc;
  const auto request =
      with_card(mine, card_with({3, 20, 30}, card::Layout::Nchw, card::Color::Bgr));
  ASSERT_TRUE(request);
  const auto p = resolve(*request, {});
  ASSERT_TRUE(p);
  EXPECT_EQ(p->tensor().to_string(), "uint8 3:8:9:1");
  EXPECT_EQ(p->order, ChannelOrder::Rgb);
  EXPECT_EQ(p->fit, Fit::Letterbox);
  EXPECT_TRUE(p->mean.empty());
  EXPECT_EQ(p->scale, (std::vector<double>{2}));
}

TEST(Request, RejectsACardOfSeveralPictures) {
  auto card = card_with({3, 20, 30}, card::Layout::Nchw, card::Color::Bgr);
  card.inputs.push_back(card.inputs[0]);
  EXPECT_SAYS(refusal(with_card({}, card)), "2 inputs");
}

std::string resolved(const Request& request, const char* shape, ElementType type) {
  const auto p = resolve(request, {type, Shape::parse(shape), ""});
  return p ? p->tensor().to_string() : p.error().what;
}

TEST(Request, CompletesOpenValuesFromTheRequiredTensor) {
  EXPECT_EQ(resolved({}, "3:30:20:1", ElementType::Float16), "float16 3:30:20:1");
  EXPECT_EQ(resolved({}, "30:20:3:1", ElementType::Int8), "int8 30:20:3:1");
  EXPECT_EQ(resolved({}, "1:30:20", ElementType::UInt8), "uint8 1:30:20:1");
  EXPECT_EQ(resolved({}, "30:20", ElementType::UInt8), "uint8 30:20:1:1");
  Request open;
  open.layout = Layout::Nchw;
  EXPECT_EQ(resolved(open, "3:3:3", ElementType::End), "uint8 3:3:3:1");
  open.order = ChannelOrder::Gray;
  EXPECT_EQ(resolved(open, "3:3:1", ElementType::End), "uint8 3:3:1:1");
}

TEST(Request, ChoosesTheTypeThatHoldsItsNumbers) {
  Request request;
  request.width = request.height = 4;
  EXPECT_EQ(resolve(request, {})->type, ElementType::UInt8);
  request.mean = std::vector<double>{1};
  EXPECT_EQ(resolve(request, {})->type, ElementType::Float32);
  request.quantisation = Quantisation{1, 0};
  EXPECT_EQ(resolve(request, {})->type, ElementType::UInt8);
}

TEST(Request, ReportsThatTheSizeIsUnknown) {
  Request request;
  request.width = 4;
  EXPECT_SAYS(refusal(resolve(request, {})), "the size of the tensor is unknown");
  EXPECT_SAYS(refusal(resolve(request, {})), "fix: tensor_preprocess width=224");
}

TEST(Request, OffersEachPossibleTensor) {
  Request request;
  ASSERT_EQ(possible_frames(request).size(), 1u);
  EXPECT_FALSE(possible_frames(request)[0][0].shape.valid());
  request.width = 5;
  request.height = 6;
  std::string shapes;
  for (const auto& frame : possible_frames(request)) shapes += frame[0].shape.to_string() + " ";
  EXPECT_EQ(shapes, "3:5:6:1 5:6:3:1 1:5:6:1 5:6:1:1 ");
  request.order = ChannelOrder::Bgr;
  request.layout = Layout::Nchw;
  request.type = ElementType::Int8;
  ASSERT_EQ(possible_frames(request).size(), 1u);
  EXPECT_EQ(possible_frames(request)[0][0].to_string(), "int8 5:6:3:1");
}

}  // namespace request_test
}  // namespace weir::preprocess
