// Transpose: grammar, shapes, and data against plain index loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/transform/transform_test_support.hpp"
#include "says.hpp"

namespace weir::transform {
namespace transpose_test {

using test::for_each_target;

using Order = std::vector<size_t>;

std::string text_of(const Order& order) {
  std::string text;
  for (const size_t index : order) text += (text.empty() ? "" : ":") + std::to_string(index);
  return text;
}

// Each output element looks up its input: first the coordinates, then the flat index.
std::vector<std::byte> reference(const Order& order, const Shape& in, size_t element,
                                 const std::vector<std::byte>& bytes) {
  std::vector<size_t> size(kRankLimit), stride(kRankLimit), source(kRankLimit);
  size_t total = 1;
  for (size_t i = 0; i < kRankLimit; ++i) {
    size[i] = std::max(in[i], 1u);
    stride[i] = total;
    total *= size[i];
    source[i] = i < order.size() ? order[i] : i;
  }
  std::vector<std::byte> out(bytes.size());
  for (size_t flat = 0; flat < total; ++flat) {
    size_t rest = flat, from = 0;
    for (size_t i = 0; i < kRankLimit; ++i) {
      from += rest % size[source[i]] * stride[source[i]];
      rest /= size[source[i]];
    }
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(from * element), element,
                out.begin() + static_cast<std::ptrdiff_t>(flat * element));
  }
  return out;
}

std::vector<std::byte> random_bytes(size_t count, std::mt19937_64& random) {
  std::vector<std::byte> bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

// On every target where it is accelerated.
void expect_as_reference(const Order& order, const Shape& shape, ElementType type,
                         bool accelerate) {
  std::mt19937_64 random(*shape.count());
  const TensorSpec spec{type, shape, ""};
  const auto in = random_bytes(*spec.bytes(), random);
  const auto expected = reference(order, shape, element_size(type), in);
  // An offset of one byte on both sides, because any alignment is allowed.
  std::vector<std::byte> shifted(in.size() + 1);
  std::copy(in.begin(), in.end(), shifted.begin() + 1);
  const auto check = [&] {
    const auto made = test::plan_of(Mode::Transpose, text_of(order), spec, accelerate);
    std::vector<std::byte> out(in.size() + 2, std::byte{0xEE});
    made.apply(std::span(shifted).subspan(1), std::span(out).subspan(1, in.size()));
    ASSERT_EQ(std::memcmp(expected.data(), out.data() + 1, expected.size()), 0)
        << text_of(order) << " of " << spec.to_string() << " accelerate " << accelerate;
    EXPECT_EQ(out.front(), std::byte{0xEE});
    EXPECT_EQ(out.back(), std::byte{0xEE});
  };
  accelerate ? for_each_target(check) : check();
}

constexpr ElementType kOnePerSize[] = {ElementType::UInt8, ElementType::Float16,
                                       ElementType::Float32, ElementType::Float64};

Order random_order(std::mt19937_64& random) {
  const size_t length = 4 + random() % 4;
  Order order(length);
  std::iota(order.begin(), order.end(), size_t{0});
  std::shuffle(order.begin(), length == 4 ? order.end() - 1 : order.end(), random);
  return order;
}

void check_random_orders(int rounds, bool accelerate) {
  std::mt19937_64 random(17);
  for (int i = 0; i < rounds; ++i) {
    std::vector<uint32_t> dims(1 + random() % 6);
    for (auto& dim : dims) dim = 1 + random() % 6;
    dims[random() % dims.size()] = 1 + static_cast<uint32_t>(random() % 90);
    expect_as_reference(random_order(random), Shape(dims), kOnePerSize[random() % 4], accelerate);
  }
}

TEST(Transpose, PlainPathAgreesWithIndexLoops) {
  check_random_orders(500, false);
}

TEST(Transpose, EveryTargetAgreesWithIndexLoops) {
  check_random_orders(500, true);
}

TEST(Transpose, ChannelsAreSplitAndInterleavedOnEveryTarget) {
  for (const auto type : kOnePerSize)
    for (const uint32_t channels : {1u, 2u, 3u, 4u, 5u})
      for (const uint32_t width : {1u, 15u, 33u, 64u, 129u}) {
        expect_as_reference({1, 2, 0, 3}, {channels, width, 7}, type, true);  // -> W:H:C
        expect_as_reference({2, 0, 1, 3}, {width, 7, channels}, type, true);  // -> C:W:H
        expect_as_reference({1, 0, 2, 3}, {channels, width, 3}, type, true);
        expect_as_reference({0, 2, 1, 3}, {channels, width, 9}, type, true);  // pixels move
      }
}

TEST(Transpose, PlanesOfAnySizeMoveOnEveryTarget) {
  for (const auto type : kOnePerSize)
    for (const uint32_t width : {5u, 8u, 16u, 31u, 67u, 128u})
      for (const uint32_t height : {5u, 16u, 33u, 100u, 177u})
        expect_as_reference({1, 0, 2, 3}, {width, height, 2}, type, true);
}

// Excess bytes after a pixel are overwritten, also with planes between the rows of the output.
TEST(Transpose, PixelsOfAnyPictureMoveOnEveryTarget) {
  for (const auto type : kOnePerSize)
    for (const uint32_t width : {1u, 2u, 4u, 5u, 6u, 7u, 9u, 10u, 33u, 131u, 135u})
      for (const uint32_t height : {1u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u, 34u})
        for (const uint32_t channels : {3u, 5u}) {
          expect_as_reference({0, 2, 1, 3}, {channels, width, height, 2}, type, true);
          expect_as_reference({0, 2, 3, 1, 4}, {channels, width, height, 2}, type, true);
        }
}

TEST(Transpose, AllTypesMoveUnchanged) {
  for (uint32_t i = 0; i < static_cast<uint32_t>(ElementType::End); ++i)
    expect_as_reference({2, 1, 0, 3}, {3, 5, 7, 2}, static_cast<ElementType>(i), true);
}

TEST(Transpose, RankSixteenIsReversed) {
  Order order(16);
  std::iota(order.rbegin(), order.rend(), size_t{0});
  const Shape shape{2, 1, 2, 1, 3, 1, 1, 2, 1, 2, 1, 1, 1, 2, 1, 2};
  expect_as_reference(order, shape, ElementType::Int16, true);
}

TEST(Transpose, DimensionsAfterTheFourthMoveAlong) {
  expect_as_reference({1, 0, 2, 3}, {3, 4, 2, 2, 5}, ElementType::UInt8, true);
  expect_as_reference({4, 3, 2, 1, 0}, {3, 4, 2, 2, 5, 3}, ElementType::UInt8, true);
}

TEST(Transpose, IdentityIsACopyWithAWarning) {
  const auto operation = parse(Mode::Transpose, "0:1:2:3");
  ASSERT_TRUE(operation);
  EXPECT_EQ(operation->warnings.size(), 1u);
  const auto made = plan(*operation, {ElementType::UInt8, {3, 4}, ""}, true);
  EXPECT_TRUE(made->is_copy());
  EXPECT_TRUE(made->in_place_possible());
  expect_as_reference({0, 1, 2, 3}, {3, 4}, ElementType::UInt8, true);
}

TEST(Transpose, MovingOnlyOnesIsACopy) {
  const TensorSpec spec{ElementType::UInt8, {1, 4, 1, 2}, ""};
  EXPECT_TRUE(test::plan_of(Mode::Transpose, "1:0:2:3", spec, true).is_copy());
  EXPECT_FALSE(test::plan_of(Mode::Transpose, "1:0:2:3", {ElementType::UInt8, {2, 4}, ""}, true)
                   .in_place_possible());
}

TEST(Transpose, ShortSpansAreNotWritten) {
  const auto made =
      test::plan_of(Mode::Transpose, "1:0:2:3", {ElementType::UInt8, {4, 4}, ""}, true);
  std::vector<std::byte> in(16, std::byte{1}), out(16, std::byte{0xEE});
  made.apply(std::span(in).first(15), out);
  made.apply(in, std::span(out).first(15));
  made.apply({}, {});
  EXPECT_EQ(out, std::vector<std::byte>(16, std::byte{0xEE}));
}

std::string output_shape(const char* option, const Shape& in) {
  const auto out = output_spec(*parse(Mode::Transpose, option), {ElementType::UInt8, in, ""});
  return out ? out->shape.to_string() : out.error().message();
}

TEST(TransposeShape, EachDimensionComesFromTheOneItNames) {
  EXPECT_EQ(output_shape("1:2:0:3", {3, 640, 480, 1}), "640:480:3:1");
  EXPECT_EQ(output_shape("1:0:2:3", {3, 4}), "4:3");
  EXPECT_EQ(output_shape("2:0:1:3", {3, 4}), "1:3:4");
  EXPECT_EQ(output_shape("4:3:2:1:0", {3, 4}), "1:1:1:4:3");
  EXPECT_EQ(output_shape("1:0:2:3", {3, 4, 5, 6, 7}), "4:3:5:6:7");
}

TEST(TransposeShape, TheInputIsDerivedFromTheOutput) {
  std::mt19937_64 random(23);
  for (int i = 0; i < 200; ++i) {
    std::vector<uint32_t> dims(1 + random() % 7);
    for (auto& dim : dims) dim = 1 + random() % 9;
    const auto operation = parse(Mode::Transpose, text_of(random_order(random)));
    ASSERT_TRUE(operation);
    const auto out = output_candidates(*operation, {ElementType::Int8, Shape(dims)});
    const auto in = input_candidates(*operation, out);
    ASSERT_TRUE(in);
    EXPECT_EQ(in->shape, Shape(dims));
    EXPECT_EQ(in->type, ElementType::Int8);
  }
}

TEST(TransposeShape, OpenPartsStayOpen) {
  const auto operation = parse(Mode::Transpose, "1:0:2:3");
  const auto in = input_candidates(*operation, {});
  ASSERT_TRUE(in);
  EXPECT_TRUE(in->type_open());
  EXPECT_TRUE(in->shape_open());
}

TEST(TransposeOption, ReadsFourAndMoreIndices) {
  for (const char* option :
       {"0:2:1:3", "2:1:0:3", "4:3:2:1:0", "1:0:2:3:4", "15:14:13:12:11:10:9:8:7:6:5:4:3:2:1:0"}) {
    const auto operation = parse(Mode::Transpose, option);
    ASSERT_TRUE(operation) << option;
    EXPECT_EQ(operation->mode(), Mode::Transpose);
    EXPECT_TRUE(operation->warnings.empty());
  }
}

TEST(TransposeOption, OtherTextsAreRejected) {
  for (const char* option : {"",        ":",        "1",        "1:0",       "1:0:2",
                             "1:0:2:",  ":1:0:2:3", "1:0:2:3:", "1:1:2:3",   "0:1:2:2",
                             "0:1:2:4", "1:0:2:a",  "1 :0:2:3", " 1:0:2:3",  "1:0:2:3 ",
                             "1,0,2,3", "-1:0:2:3", "01:0:2:3", "1:0:2:3:5", "0:1:2:3:3",
                             "1::2:3",  "+1:0:2:3"}) {
    const auto operation = parse(Mode::Transpose, option);
    ASSERT_FALSE(operation) << option;
    EXPECT_EQ(operation.error().code, Code::OPTION_SYNTAX) << option;
    EXPECT_SAYS(operation.error().difference, *option ? "^" : "it is empty") << option;
  }
  for (const char* option : {"16:0:1:2:3", "99999999999999999999:0:1:3"})
    EXPECT_EQ(parse(Mode::Transpose, option).error().code, Code::OPTION_VALUE) << option;
}

TEST(TransposeOption, FourIndicesEndWithThree) {
  const auto operation = parse(Mode::Transpose, "3:0:1:2");
  ASSERT_FALSE(operation);
  EXPECT_EQ(operation.error().code, Code::OPTION_SYNTAX);
  EXPECT_EQ(operation.error().difference, "at character 7:\n    3:0:1:2\n          ^");
  EXPECT_EQ(operation.error().fix, "option=3:0:1:2:4");
  EXPECT_TRUE(parse(Mode::Transpose, "3:0:1:2:4"));
}

TEST(TransposeOption, ReportsThePlaceOfAnInvalidIndex) {
  for (const auto& [option, place] :
       {std::pair{"1:2:0:4", "at character 7:\n    1:2:0:4\n          ^"},
        {"1:12:0:2:3", "at character 3:\n    1:12:0:2:3\n      ^"}}) {
    const auto operation = parse(Mode::Transpose, option);
    ASSERT_FALSE(operation);
    EXPECT_EQ(operation.error().difference, place);
  }
}

}  // namespace transpose_test
}  // namespace weir::transform
