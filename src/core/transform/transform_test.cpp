// The entry points of the transform: modes, negotiation, and branch-free float16.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform.hpp"

#include <gtest/gtest.h>
#include <bit>
#include <cmath>

#include "core/transform/float16_bits.hpp"

namespace weir::transform {
namespace transform_test {

TEST(TransformMode, NamesRoundTrip) {
  for (int32_t i = 0; i <= 6; ++i)
    EXPECT_EQ(parse_mode(to_string(static_cast<Mode>(i))), static_cast<Mode>(i));
  EXPECT_EQ(parse_mode("ArithMetic"), Mode::Arithmetic);
  EXPECT_EQ(to_string(Mode::Unknown), "unknown");
  EXPECT_EQ(to_string(static_cast<Mode>(7)), "unknown");
}

TEST(TransformMode, OtherNamesAreUnknown) {
  for (const char* nick : {"", "unknown", "arith", "typecast ", "1"})
    EXPECT_EQ(parse_mode(nick), Mode::Unknown) << nick;
}

TEST(TransformMode, EachOptionIsReadByItsOwnMode) {
  const std::pair<Mode, const char*> options[] = {
      {Mode::Dimchg, "0:2"},        {Mode::Typecast, "int8"}, {Mode::Arithmetic, "add:1"},
      {Mode::Transpose, "1:0:2:3"}, {Mode::Stand, "default"}, {Mode::Clamp, "0:1"},
      {Mode::Padding, "left:1"}};
  for (const auto& [mode, option] : options) {
    const auto operation = parse(mode, option);
    ASSERT_TRUE(operation) << option;
    EXPECT_EQ(operation->mode(), mode);
  }
}

// As wherever a type is named; docs/compatibility/types-and-caps.md 1.2.
TEST(TransformMode, TheTypeOfATypecastMayHaveBlanksAround) {
  for (const char* option : {"float32", " float32", "float32 ", "  FLOAT32\t"}) {
    const auto operation = parse(Mode::Typecast, option);
    ASSERT_TRUE(operation) << option;
    EXPECT_EQ(output_candidates(*operation, {ElementType::UInt8, {3}}).type, ElementType::Float32);
  }
  for (const char* option : {"float 32", " float32x", "float32,", " ", ""})
    EXPECT_FALSE(parse(Mode::Typecast, option)) << option;
}

TEST(TransformMode, NoModeIsAnError) {
  for (const Mode mode : {Mode::Unknown, static_cast<Mode>(99)}) {
    const auto operation = parse(mode, "float32");
    ASSERT_FALSE(operation);
    EXPECT_EQ(operation.error().code, Code::MODE_UNKNOWN);
    EXPECT_EQ(operation.error().fix, "mode=typecast option=float32");
  }
}

TEST(TransformNegotiation, TypecastLeavesTheInputsTypeOpen) {
  const auto operation = parse(Mode::Typecast, "float32");
  const auto in = input_candidates(*operation, {ElementType::Float32, {3, 4}});
  ASSERT_TRUE(in);
  EXPECT_TRUE(in->type_open());
  EXPECT_EQ(in->shape, (Shape{3, 4}));
  EXPECT_TRUE(input_candidates(*operation, {}));
  EXPECT_FALSE(input_candidates(*operation, {ElementType::UInt8, {3, 4}}));
  EXPECT_EQ(output_candidates(*operation, {}).type, ElementType::Float32);
}

TEST(TransformNegotiation, InvalidTensorsAreRejected) {
  const auto operation = parse(Mode::Typecast, "float32");
  for (const TensorSpec& spec :
       {TensorSpec{}, TensorSpec{ElementType::UInt8, {}, ""}, TensorSpec{ElementType::End, {3}, ""},
        TensorSpec{ElementType::UInt8, {3, 0, 2}, ""}}) {
    EXPECT_EQ(output_spec(*operation, spec).error().code, Code::SPEC_MISMATCH);
    EXPECT_EQ(plan(*operation, spec, true).error().code, Code::SPEC_MISMATCH);
  }
}

TEST(TransformNegotiation, TensorsThatGrowBeyondTheLimitAreRejected) {
  const auto operation = parse(Mode::Typecast, "float64");
  const TensorSpec huge{ElementType::UInt8, {0x80000000u, 0x80000000u}, ""};
  EXPECT_EQ(output_spec(*operation, huge).error().code, Code::LIMIT_EXCEEDED);
  const TensorSpec beyond{ElementType::UInt8, {0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu}, ""};
  EXPECT_EQ(plan(*operation, beyond, true).error().code, Code::LIMIT_EXCEEDED);
}

TEST(Float16Bits, WidensEveryHalfAsFloat16Does) {
  for (uint32_t bits = 0; bits < 0x10000u; ++bits) {
    float16 half;
    half.bits = static_cast<uint16_t>(bits);
    ASSERT_EQ(std::bit_cast<uint32_t>(widen(half)),
              std::bit_cast<uint32_t>(static_cast<float>(half)))
        << bits;
  }
}

TEST(Float16Bits, RoundsAsFloat16Does) {
  for (uint64_t bits = 0; bits <= 0xFFFFFFFFu; bits += 4093) {
    const auto value = std::bit_cast<float>(static_cast<uint32_t>(bits));
    ASSERT_EQ(round_to_half(value).bits, float16(value).bits) << bits;
  }
  for (uint32_t half = 0; half < 0x7C00u; ++half) {  // each half, and the adjacent ties
    float16 exact;
    exact.bits = static_cast<uint16_t>(half);
    const auto middle = std::bit_cast<uint32_t>(static_cast<float>(exact)) + 0x1000u;
    for (const uint32_t near : {middle - 1, middle, middle + 1}) {
      const auto value = std::bit_cast<float>(near);
      ASSERT_EQ(round_to_half(value).bits, float16(value).bits) << near;
      ASSERT_EQ(round_to_half(-value).bits, float16(-value).bits) << near;
    }
  }
}

}  // namespace transform_test
}  // namespace weir::transform
