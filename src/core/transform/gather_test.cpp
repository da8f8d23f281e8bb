// Tensors with gaps give the same bits as after copying them to dense memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform_test_support.hpp"

#include "says.hpp"

namespace weir::transform {
namespace gather_test {

using Bytes = std::vector<std::byte>;

Bytes random_bytes(size_t size, uint32_t seed) {
  std::mt19937 random(seed);
  Bytes out(size);
  for (auto& byte : out) byte = static_cast<std::byte>(random());
  return out;
}
Bytes applied(const TransformPlan& plan, const Bytes& in) {
  Bytes out(*plan.output().bytes());
  plan.apply(in, out);
  return out;
}
// Copies element by element by the definition of strides.
Bytes gathered(const TensorSpec& tensor, const StridedLayout& layout, const Bytes& in) {
  Bytes out;
  const size_t size = element_size(tensor.type);
  for (uint64_t n = 0; n < *tensor.shape.count(); ++n) {
    uint64_t rest = n;
    auto at = static_cast<int64_t>(layout.offset);
    for (size_t i = 0; i < tensor.shape.rank(); ++i) {
      at += static_cast<int64_t>(rest % tensor.shape[i]) * layout.strides[i];
      rest /= tensor.shape[i];
    }
    out.insert(out.end(), in.begin() + at, in.begin() + at + static_cast<int64_t>(size));
  }
  return out;
}

struct Case {
  TensorSpec tensor;
  StridedLayout layout;
};
const std::vector<Case> kCases{
    {{ElementType::UInt8, {3, 5, 4}, ""}, {0, {1, 3, 16}}},             // padded rows
    {{ElementType::UInt8, {3, 300, 40}, ""}, {7, {1, 3, 1000}}},        // a region of long rows
    {{ElementType::UInt8, {3, 50, 40}, ""}, {39 * 160, {1, 3, -160}}},  // bottom-up
    {{ElementType::UInt8, {3, 2000, 5}, ""}, {0, {1, 4, 8000}}},        // three channels of four
    {{ElementType::UInt16, {1000, 7, 2}, ""}, {64, {2, 2048, 20000}}},
    {{ElementType::UInt8, {640, 480, 3}, ""}, {0, {1, 640, 320000}}},  // planes apart
    {{ElementType::UInt8, {12, 4}, ""}, {0, {1, 12}}},                 // no gap
};

TEST(Gather, CollectsTheElements) {
  for (const auto& [tensor, layout] : kCases) {
    const auto plan = gather_plan(tensor, layout);
    ASSERT_TRUE(plan) << plan.error().message();
    EXPECT_TRUE(plan->is_gather());
    EXPECT_FALSE(plan->in_place_possible());
    const Bytes in = random_bytes(*plan->input().bytes(), 5);
    EXPECT_EQ(applied(*plan, in), gathered(tensor, layout, in)) << tensor.to_string();
  }
}

TEST(Gather, AppliesElementWiseOperations) {
  for (const auto& [tensor, layout] : kCases) {
    const auto gather = gather_plan(tensor, layout);
    ASSERT_TRUE(gather);
    const Bytes in = random_bytes(*gather->input().bytes(), 6);
    const Bytes dense = gathered(tensor, layout, in);
    for (const auto& [mode, option] : std::vector<std::pair<Mode, const char*>>{
             {Mode::Typecast, "float32"},
             {Mode::Arithmetic, "typecast:float32,add:-127.5,div:127.5"},
             {Mode::Arithmetic, "per-channel:true@0,add:1@0,mul:3@2"},
             {Mode::Clamp, "20:90"}})
      for (const bool accelerate : {true, false}) {
        const auto work = test::plan_of(mode, option, tensor, accelerate);
        const auto both = fused(*gather, work);
        ASSERT_TRUE(both) << option;
        EXPECT_FALSE(both->is_gather());
        EXPECT_EQ(applied(*both, in), applied(work, dense))
            << option << " of " << tensor.to_string();
        const auto limit = test::plan_of(Mode::Clamp, "30:60", both->output(), accelerate);
        const auto three = fused(*both, limit);
        ASSERT_TRUE(three);
        EXPECT_EQ(applied(*three, in), applied(limit, applied(*both, in)));
      }
  }
}

TEST(Gather, LeavesOtherWorkToASecondPass) {
  const auto gather = gather_plan(kCases[0].tensor, kCases[0].layout);
  EXPECT_FALSE(fused(*gather, test::plan_of(Mode::Transpose, "1:0:2:3", kCases[0].tensor, true)));
  EXPECT_FALSE(fused(*gather, test::plan_of(Mode::Stand, "default", kCases[0].tensor, true)));
}

TEST(Gather, NeverReadsBeyondTheInput) {
  const auto gather = gather_plan(kCases[0].tensor, kCases[0].layout);
  const Bytes in = random_bytes(20, 1);  // one row and part of the next
  Bytes out(*gather->output().bytes(), std::byte{0xEE});
  gather->apply(in, out);
  EXPECT_EQ(Bytes(out.begin(), out.begin() + 15), Bytes(in.begin(), in.begin() + 15));
  EXPECT_EQ(Bytes(out.begin() + 15, out.end()), Bytes(out.size() - 15, std::byte{0xEE}));
  Bytes little(20, std::byte{0xEE});  // room for one row
  gather->apply(random_bytes(*gather->input().bytes(), 2), little);
  EXPECT_EQ(little[15], std::byte{0xEE});
}

TEST(Gather, RejectsStridesOutsideTheMemory) {
  const TensorSpec rows{ElementType::UInt8, {4, 3}, ""};
  const auto before = gather_plan(rows, {7, {1, -4}});
  ASSERT_FALSE(before);
  EXPECT_EQ(before.error().code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(before.error().message(), "lead outside its memory");
  const auto far = gather_plan(rows, {0, {1, int64_t{1} << 40}});
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, Code::LIMIT_EXCEEDED);
  EXPECT_FALSE(gather_plan({ElementType::UInt8, {}, ""}, {0, {}}));
}

}  // namespace gather_test
}  // namespace weir::transform
