// Chains of any types: converts a block and runs each column over it while it is in the L1 cache.
// The loops have constant lengths and no branches, so the compiler vectorises them for each target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "core/transform/chain_program.hpp"
#include "core/transform/float16_bits.hpp"
#include "core/transform/number_rules.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/chain_blocks.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#include "core/transform/cast_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {

// Processes kChainBlock elements; the memories do not overlap and are aligned.
using ColumnBlock = void (*)(std::byte* values, const std::byte* operands) noexcept;

template <class T>
T apply_op(ColumnOp op, T x, T operand) noexcept {
  if (op == ColumnOp::Add) return add<T>(x, operand);
  if (op == ColumnOp::Mul) return mul<T>(x, operand);
  if constexpr (std::integral<T> && sizeof(T) <= 2) {
    // Exact: a quotient of 16-bit numbers is never closer to the next integer than float can
    // resolve.
    return static_cast<T>(
        static_cast<int32_t>(static_cast<float>(x) / static_cast<float>(operand)));
  } else if constexpr (std::integral<T> && sizeof(T) == 4) {
    return static_cast<T>(
        static_cast<int64_t>(static_cast<double>(x) / static_cast<double>(operand)));
  } else {
    return div<T>(x, operand);
  }
}

template <class T, ColumnOp kOp>
void column_block(std::byte* values, const std::byte* operands) noexcept {
  T* HWY_RESTRICT x = reinterpret_cast<T*>(values);
  const T* HWY_RESTRICT y = reinterpret_cast<const T*>(operands);
  for (size_t i = 0; i < kChainBlock; ++i) {
    if constexpr (std::same_as<T, float16>) {
      x[i] = round_to_half(apply_op<float>(kOp, widen(x[i]), widen(y[i])));
    } else {
      x[i] = apply_op<T>(kOp, x[i], y[i]);
    }
  }
}

CastBlock cast_for(ElementType from, ElementType to) noexcept {
  return visit_type(from, [to](auto from_tag) {
    return visit_type(to, [](auto to_tag) -> CastBlock {
      return cast_block<typename decltype(from_tag)::type, typename decltype(to_tag)::type>;
    });
  });
}

ColumnBlock column_for(ColumnOp op, ElementType type) noexcept {
  return visit_type(type, [op](auto tag) -> ColumnBlock {
    using T = typename decltype(tag)::type;
    switch (op) {
      case ColumnOp::Add:
        return column_block<T, ColumnOp::Add>;
      case ColumnOp::Mul:
        return column_block<T, ColumnOp::Mul>;
      case ColumnOp::Div:
      case ColumnOp::DivByReciprocal:
        break;  // the divisor is available as well
    }
    return column_block<T, ColumnOp::Div>;
  });
}

void RunBlocks(const ChainProgram& program, const std::byte* in, std::byte* out, size_t count,
               ElementType from, ElementType to) {
  alignas(64) std::byte source[kChainBlock * 8];
  alignas(64) std::byte values[kChainBlock * 8];
  const size_t in_bytes = element_size(from), out_bytes = element_size(to);
  const auto cast = cast_for(from, to);
  size_t phase = 0;
  for (size_t i = 0; i < count; i += kChainBlock) {
    const size_t length = std::min(kChainBlock, count - i);
    std::memcpy(source, in + i * in_bytes, length * in_bytes);
    if (length < kChainBlock)
      std::memset(source + length * in_bytes, 0, (kChainBlock - length) * in_bytes);
    cast(source, values);
    for (const auto& column : program.columns)
      column_for(column.op, to)(values, column.operands.data() + phase * out_bytes);
    std::memcpy(out + i * out_bytes, values, length * out_bytes);
    phase = (phase + kChainBlock) % program.period;
  }
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunBlocks);

void run_chain_blocks(const ChainProgram& program, const std::byte* in, std::byte* out,
                      size_t count, ElementType from, ElementType to) noexcept {
  HWY_DYNAMIC_DISPATCH(RunBlocks)(program, in, out, count, from, to);
}

}  // namespace weir::transform
#endif
