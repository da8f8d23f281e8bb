// mode=padding: grammar, shapes, and data against plain index loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

#include "says.hpp"

namespace weir::transform {
namespace padding_test {

using Sides = std::array<uint32_t, 6>;  // before and after of dimensions 0, 1, 2

std::string option_of(const Sides& sides) {
  const char* names[] = {"left", "right", "top", "bottom", "front", "back"};
  std::string out;
  for (size_t i = 0; i < 6; ++i)
    out += (i ? "," : "") + std::string(names[i]) + ":" + std::to_string(sides[i]);
  return out;
}

template <class T>
std::vector<T> reference(const std::vector<T>& in, const Shape& shape, const Sides& sides) {
  const auto extent = [&](size_t i) { return i < shape.rank() ? shape[i] : 1u; };
  const size_t w = extent(0), h = extent(1), d = extent(2), blocks = in.size() / (w * h * d);
  const size_t out_w = w + sides[0] + sides[1], out_h = h + sides[2] + sides[3],
               out_d = d + sides[4] + sides[5];
  std::vector<T> out(out_w * out_h * out_d * blocks, T{});
  for (size_t b = 0; b < blocks; ++b)
    for (size_t z = 0; z < d; ++z)
      for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x)
          out[((b * out_d + z + sides[4]) * out_h + y + sides[2]) * out_w + x + sides[0]] =
              in[((b * d + z) * h + y) * w + x];
  return out;
}

template <class T>
void expect_as_reference(const Shape& shape, const Sides& sides, std::mt19937_64& random) {
  SCOPED_TRACE(option_of(sides) + " of " + shape.to_string());
  const auto in = test::random_values<T>(*shape.count(), random);
  const auto expected = reference(in, shape, sides);
  const auto plan =
      test::plan_of(Mode::Padding, option_of(sides), {test::type_of<T>(), shape, ""}, true);
  ASSERT_EQ(*plan.output().shape.count(), expected.size());
  std::vector<T> out(expected.size());
  std::memset(static_cast<void*>(out.data()), 0xEE, out.size() * sizeof(T));
  plan.apply(test::bytes_of(in), std::as_writable_bytes(std::span(out)));
  EXPECT_EQ(std::memcmp(out.data(), expected.data(), out.size() * sizeof(T)), 0);
}

TEST(Padding, PutsZerosAroundAnyShape) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 300; ++round) {
    Shape shape;
    const size_t rank = 1 + random() % 5;
    for (size_t i = 0; i < rank; ++i) shape[i] = static_cast<uint32_t>(1 + random() % 5);
    Sides sides;
    for (auto& side : sides) side = static_cast<uint32_t>(random() % 4);
    expect_as_reference<uint8_t>(shape, sides, random);
    expect_as_reference<double>(shape, sides, random);
    expect_as_reference<float16>(shape, sides, random);
  }
}

TEST(Padding, GivesTheDocumentedShapes) {
  const auto shape = [](const char* option, const Shape& in) {
    return test::plan_of(Mode::Padding, option, {ElementType::UInt8, in, ""}, true)
        .output()
        .shape.to_string();
  };
  EXPECT_EQ(shape("left:1,right:2,top:3,bottom:4,front:5,back:6", {10, 20, 30, 2}), "13:27:41:2");
  EXPECT_EQ(shape("left:1right:2layout:NCHW", {10, 20, 30}), "13:20:30");
  EXPECT_EQ(shape("left:1,right:2,top:3,layout:NHWC", {3, 20, 30}), "3:23:33");
  EXPECT_EQ(shape("front:1,back:2,layout:nhwc", {3, 20, 30}), "6:20:30");
  EXPECT_EQ(shape("LEFT:1,left:3", {2, 2}), "5:2") << "the last word counts";
  EXPECT_EQ(shape("front:2", {3, 4}), "3:4:3") << "what is missing counts as 1";
  EXPECT_EQ(shape("top:12", {7}), "7:13");
}

TEST(Padding, LeavesTheShapeOpenForCaps) {
  const auto operation = parse(Mode::Padding, "left:1");
  const auto in = input_candidates(*operation, {ElementType::Int8, {4}});
  EXPECT_EQ(in->type, ElementType::Int8);
  EXPECT_TRUE(in->shape_open());
  EXPECT_TRUE(output_candidates(*operation, {}).shape_open());
}

TEST(Padding, WarnsWhenNothingIsAdded) {
  const auto operation = parse(Mode::Padding, "left:0,top:0");
  ASSERT_TRUE(operation);
  EXPECT_EQ(operation->warnings.size(), 1u);
  EXPECT_TRUE(
      test::plan_of(Mode::Padding, "left:0", {ElementType::UInt8, {3, 4}, ""}, true).is_copy());
}

TEST(Padding, RejectsWhatItCannotRead) {
  for (const auto& [option, needed] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "left, right, top"},
           {"lft:1", "left, right, top"},
           {"left=1", "':' and how many zeros"},
           {"left:", "how many zeros"},
           {"left:-1", "how many zeros"},
           {"left:65537", "at most 65536"},
           {"left:1,,right:1", "left, right, top"},
           {"left:1,layout:NWHC", "NCHW or NHWC"},
           {"left:1,layout:NHWC,top:1", "the end after the layout"}}) {
    const auto operation = parse(Mode::Padding, option);
    ASSERT_FALSE(operation) << option;
    EXPECT_SAYS(operation.error().needed, needed) << option << ": " << operation.error().needed;
  }
}

TEST(Padding, RejectsOversizedPadding) {
  const auto operation = parse(Mode::Padding, "left:65536");
  EXPECT_FALSE(output_spec(*operation, {ElementType::UInt8, {UINT32_MAX}, ""}));
}

TEST(Padding, NeverWritesBeyondASpanThatIsTooShort) {
  const auto plan =
      test::plan_of(Mode::Padding, "left:1,top:1", {ElementType::UInt8, {3, 4}, ""}, true);
  const std::vector<std::byte> in(12, std::byte{1});
  std::vector<std::byte> out(19, std::byte{7});
  plan.apply(in, out);
  EXPECT_EQ(out, std::vector<std::byte>(19, std::byte{7}));
}

}  // namespace padding_test
}  // namespace weir::transform
