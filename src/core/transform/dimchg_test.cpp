// mode=dimchg: grammar, shapes, and data as in NumPy's moveaxis.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

#include "says.hpp"

namespace weir::transform {
namespace dimchg_test {

// The order of the output's dimensions: removes one and inserts it elsewhere.
std::vector<size_t> moved(size_t from, size_t to) {
  std::vector<size_t> order;
  for (size_t i = 0; i < kRankLimit; ++i)
    if (i != from) order.push_back(i);
  order.insert(order.begin() + static_cast<std::ptrdiff_t>(to), from);
  return order;
}

TEST(Dimchg, MovesOneDimensionAndTheOthersFollow) {
  const Shape shape{3, 5, 4, 2};
  const TensorSpec spec{ElementType::UInt16, shape, ""};
  std::vector<uint16_t> in(*shape.count());
  for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<uint16_t>(i * 7);
  for (size_t from = 0; from < 4; ++from) {
    for (size_t to = 0; to < 4; ++to) {
      const auto option = std::to_string(from) + ":" + std::to_string(to);
      const auto order = moved(from, to);
      for (const bool accelerate : {true, false}) {
        const auto plan = test::plan_of(Mode::Dimchg, option, spec, accelerate);
        std::vector<uint16_t> out(in.size());
        plan.apply(test::bytes_of(in), std::as_writable_bytes(std::span(out)));
        size_t at[4] = {}, flat = 0;  // coordinates in the output
        const auto& size = plan.output().shape;
        for (at[3] = 0; at[3] < size[3]; ++at[3])
          for (at[2] = 0; at[2] < size[2]; ++at[2])
            for (at[1] = 0; at[1] < size[1]; ++at[1])
              for (at[0] = 0; at[0] < size[0]; ++at[0]) {
                size_t source[4] = {};
                for (size_t i = 0; i < 4; ++i) source[order[i]] = at[i];
                const size_t index = source[0] + 3 * (source[1] + 5 * (source[2] + 4 * source[3]));
                ASSERT_EQ(out[flat++], in[index]) << option;
              }
      }
    }
  }
}

TEST(Dimchg, GivesTheDocumentedShapes) {
  const auto shape = [](const char* option, const Shape& in) {
    return test::plan_of(Mode::Dimchg, option, {ElementType::UInt8, in, ""}, true).output().shape;
  };
  EXPECT_EQ(shape("0:2", {3, 224, 112, 1}), (Shape{224, 112, 3, 1}));
  EXPECT_EQ(shape("2:0", {224, 112, 3}), (Shape{3, 224, 112}));
  EXPECT_EQ(shape("1:1", {3, 4}), (Shape{3, 4}));
  EXPECT_EQ(shape("0:3", {3, 4}).to_string(), "4:1:1:3");  // missing dimensions count as 1
}

TEST(Dimchg, InvertsForCaps) {
  const auto operation = parse(Mode::Dimchg, "0:2");
  EXPECT_EQ(input_candidates(*operation, {ElementType::UInt8, {224, 112, 3}})->shape,
            (Shape{3, 224, 112}));
}

TEST(Dimchg, WarnsWhenNothingMoves) {
  const auto operation = parse(Mode::Dimchg, "2:2");
  ASSERT_TRUE(operation);
  ASSERT_EQ(operation->warnings.size(), 1u);
  EXPECT_SAYS(operation->warnings[0], "changes nothing");
  EXPECT_TRUE(
      test::plan_of(Mode::Dimchg, "2:2", {ElementType::UInt8, {3, 4, 5}, ""}, true).is_copy());
  EXPECT_TRUE(parse(Mode::Dimchg, "0:15")->warnings.empty());
}

TEST(Dimchg, RejectsWhatItCannotRead) {
  for (const auto& [option, needed] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "the number of a dimension"},
           {"0", "':' and the place"},
           {"0-2", "':' and the place"},
           {"0:", "the number of a dimension"},
           {"00:1", "the number of a dimension"},
           {"0:16", "at most 15"},
           {"99999999999999999999:1", "at most 15"},
           {"0:1:2", "the end"}}) {
    const auto operation = parse(Mode::Dimchg, option);
    ASSERT_FALSE(operation) << option;
    EXPECT_SAYS(operation.error().needed, needed) << option << ": " << operation.error().needed;
    EXPECT_EQ(operation.error().fix, "option=0:2");
  }
}

}  // namespace dimchg_test
}  // namespace weir::transform
