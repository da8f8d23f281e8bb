// Compares concatenation with an element-wise model, for random shapes, ranks, types and pads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/merge/concatenation.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "says.hpp"

namespace weir {
namespace concatenation_test {

using Bytes = std::vector<std::byte>;

struct Merged {
  TensorSpec spec;
  Bytes bytes;
};

Merged merge(const std::vector<TensorSpec>& specs, const std::vector<Bytes>& inputs,
             size_t dimension) {
  const auto plan = Concatenation::plan(specs, dimension);
  EXPECT_TRUE(plan);
  Merged out{plan->output(), Bytes(static_cast<size_t>(*plan->output().bytes()))};
  std::vector<std::span<const std::byte>> views(inputs.begin(), inputs.end());
  plan->run(views, out.bytes);
  return out;
}

// Copies each element by its coordinates.
Bytes model_of(const std::vector<TensorSpec>& specs, const std::vector<Bytes>& inputs,
               size_t dimension, const Shape& merged) {
  const size_t size = element_size(specs[0].type);
  Bytes out;
  std::vector<size_t> at(kRankLimit, 0);
  for (uint64_t n = *merged.count(); n > 0; --n) {
    size_t pad = 0, place = at[dimension];
    while (place >= std::max(specs[pad].shape[dimension], 1u))
      place -= std::max(specs[pad++].shape[dimension], 1u);
    size_t offset = 0;
    for (size_t d = kRankLimit; d-- > 0;)
      offset = offset * std::max(specs[pad].shape[d], 1u) + (d == dimension ? place : at[d]);
    const auto from = inputs[pad].begin() + static_cast<std::ptrdiff_t>(offset * size);
    out.insert(out.end(), from, from + static_cast<std::ptrdiff_t>(size));
    for (size_t d = 0; d < kRankLimit && ++at[d] == std::max(merged[d], 1u); ++d) at[d] = 0;
  }
  return out;
}

TEST(Concatenation, AgreesWithTheModelForAnyShape) {
  std::mt19937 random(1);
  for (int round = 0; round < 400; ++round) {
    const auto type = static_cast<ElementType>(random() % 11);
    const size_t rank = 1 + random() % 16, dimension = random() % 16;
    std::vector<uint32_t> dims;
    for (size_t d = 0; d < rank; ++d) dims.push_back(random() % 3 == 0 ? 1 + random() % 4 : 1);
    std::vector<TensorSpec> specs;
    std::vector<Bytes> inputs;
    for (size_t pad = 0; pad < 1 + random() % 5; ++pad) {
      Shape shape(dims);
      if (dimension < rank) shape[dimension] = 1 + random() % 20;
      specs.push_back({type, shape, ""});
      Bytes bytes(static_cast<size_t>(*specs.back().bytes()));
      for (auto& b : bytes) b = static_cast<std::byte>(random());
      inputs.push_back(bytes);
    }
    const Merged got = merge(specs, inputs, dimension);
    ASSERT_EQ(got.bytes, model_of(specs, inputs, dimension, got.spec.shape)) << round;
  }
}

TEST(Concatenation, MissingDimensionsAreOne) {
  const TensorSpec flat{ElementType::UInt8, Shape{2, 3}, ""};
  const TensorSpec full{ElementType::UInt8, Shape{2, 3, 1, 1}, ""};
  EXPECT_EQ(Concatenation::plan(std::vector{flat, full}, 1)->output().shape.to_string(), "2:6:1:1");
  EXPECT_EQ(Concatenation::plan(std::vector{flat, flat}, 3)->output().shape.to_string(), "2:3:1:2");
  const auto last = Concatenation::plan(std::vector{flat, flat, flat}, 15);
  EXPECT_EQ(last->output().shape[15], 3u);
  EXPECT_EQ(last->output().shape.rank(), 16u);
}

TEST(Concatenation, TilesDoNotAffectTheResult) {
  const TensorSpec rgb{ElementType::UInt8, Shape{3, 640, 48}, ""};
  const TensorSpec alpha{ElementType::UInt8, Shape{1, 640, 48}, ""};
  std::vector<Bytes> inputs{Bytes(640 * 48 * 3), Bytes(640 * 48)};
  for (size_t i = 0; i < inputs[0].size(); ++i) inputs[0][i] = static_cast<std::byte>(i % 251);
  for (size_t i = 0; i < inputs[1].size(); ++i) inputs[1][i] = static_cast<std::byte>(i % 241);
  const Merged got = merge({rgb, alpha}, inputs, 0);
  for (size_t i = 0; i < 640 * 48; ++i) {
    for (size_t c = 0; c < 3; ++c) ASSERT_EQ(got.bytes[4 * i + c], inputs[0][3 * i + c]);
    ASSERT_EQ(got.bytes[4 * i + 3], inputs[1][i]);
  }
}

// Non-temporal stores with blocks at every alignment. A row holds the bytes of every dimension up
// to the merged one, input after input.
TEST(Concatenation, LargeTensorsAreRowsOfBlocks) {
  const size_t inner[] = {5 * 8, 231 * 5 * 8, 230 * 231 * 5 * 8};  // bytes below dimensions 1, 2, 3
  for (const size_t dimension : {1u, 2u, 3u}) {
    std::vector<TensorSpec> specs;
    std::vector<Bytes> inputs;
    for (const uint32_t extra : {0u, 3u}) {
      Shape shape{5, 231, 230, 2};
      shape[dimension] += extra;
      specs.push_back({ElementType::Float64, shape, ""});
      inputs.emplace_back(static_cast<size_t>(*specs.back().bytes()));
      for (size_t i = 0; i < inputs.back().size(); ++i)
        inputs.back()[i] = static_cast<std::byte>(i * 31 / 7 + extra);
    }
    const Merged got = merge(specs, inputs, dimension);
    ASSERT_GE(got.bytes.size(), size_t{8} << 20);
    const std::byte* at = got.bytes.data();
    const size_t block = inner[dimension - 1] * specs[0].shape[dimension];
    for (size_t row = 0; row < inputs[0].size() / block; ++row)
      for (size_t pad = 0; pad < 2; ++pad) {
        const size_t size = inner[dimension - 1] * specs[pad].shape[dimension];
        ASSERT_EQ(std::memcmp(at, inputs[pad].data() + row * size, size), 0)
            << "dimension " << dimension << ", row " << row << ", pad " << pad;
        at += size;
      }
    EXPECT_EQ(at, got.bytes.data() + got.bytes.size());
  }
}

TEST(Concatenation, DifferentTypesAreReportedWithBothSides) {
  const std::vector<TensorSpec> specs{{ElementType::UInt8, Shape{2, 3}, ""},
                                      {ElementType::Float32, Shape{2, 3}, ""}};
  const auto plan = Concatenation::plan(specs, 0);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, Code::SPEC_MISMATCH);
  EXPECT_EQ(plan.error().offered, "pad 1: float32 2:3");
  EXPECT_SAYS(plan.error().needed, "uint8 2:3");
  EXPECT_EQ(plan.error().difference, "type is float32, needed is uint8");
  EXPECT_EQ(plan.error().fix, "tensor_transform mode=typecast option=uint8");
}

TEST(Concatenation, SizesThatFitAlongADifferentDimensionAreReportedWithIt) {
  const auto fix = [](const Shape& one, const Shape& two, size_t dimension) {
    const std::vector<TensorSpec> specs{{ElementType::UInt8, one, ""},
                                        {ElementType::UInt8, two, ""}};
    const auto plan = Concatenation::plan(specs, dimension);
    EXPECT_FALSE(plan);
    return plan ? std::string() : plan.error().fix;
  };
  EXPECT_EQ(fix(Shape{2, 3, 5}, Shape{2, 3, 4}, 0), "tensor_merge mode=linear option=2");
  EXPECT_EQ(fix(Shape{2, 3}, Shape{7, 3}, 1), "tensor_merge mode=linear option=0");
  EXPECT_EQ(fix(Shape{2, 3}, Shape{7, 4}, 0), "") << "they fit along none";
}

TEST(Concatenation, DifferentSizesAreReportedWithTheirDimension) {
  const std::vector<TensorSpec> specs{{ElementType::UInt8, Shape{2, 3, 5}, ""},
                                      {ElementType::UInt8, Shape{2, 3, 4}, ""}};
  EXPECT_TRUE(Concatenation::plan(specs, 2));
  const auto plan = Concatenation::plan(specs, 1);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().difference, "dimension 2 is 4, needed is 5");
}

TEST(Concatenation, TheSumHasALimit) {
  const TensorSpec huge{ElementType::UInt8, Shape{4000000000u}, ""};
  const auto plan = Concatenation::plan(std::vector{huge, huge}, 0);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, Code::LIMIT_EXCEEDED);
  EXPECT_EQ(Concatenation::plan(std::vector{huge}, 16).error().code, Code::OPTION_VALUE);
  EXPECT_FALSE(Concatenation::plan({}, 0));
}

}  // namespace concatenation_test
}  // namespace weir
