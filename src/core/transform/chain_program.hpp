// ChainProgram: the steps of a chain as columns of operands for vector instructions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transform/chain.hpp"

namespace weir::transform {

// The number of elements that a kernel processes at a time. Operand tables are readable for this
// many elements from each phase on.
inline constexpr size_t kChainBlock = 256;

enum class ColumnOp : uint8_t { Add, Mul, Div, DivByReciprocal };

// One operation with an operand for each element of the period.
struct Column {
  ColumnOp op = ColumnOp::Add;
  std::vector<std::byte> operands;  // period + kChainBlock elements of the tensor's type
  // DivByReciprocal only: 1 / operand as the sum of two floats, such that fma(x, high, x * low)
  // equals x / operand exactly; verified for every possible x.
  std::vector<std::byte> reciprocal_high, reciprocal_low;
};

struct ChainProgram {
  size_t period = 1;  // number of elements after which the operands repeat
  std::vector<Column> columns;
};

// Steps with a channel become columns with a neutral operand for all other elements. Element e of
// the period belongs to channel (e / inner) % count. Precondition: `steps` contain no division of
// integers by zero.
ChainProgram make_chain_program(ElementType from, ElementType to, std::span<const TypedStep> steps,
                                const Channels& channels);

// Runs a program over `count` elements; the first one is at the start of a period.
using ChainRunner = void (*)(const ChainProgram& program, const std::byte* in, std::byte* out,
                             size_t count, ElementType from, ElementType to) noexcept;

// Any types, block by block. (chain_blocks.cpp)
void run_chain_blocks(const ChainProgram& program, const std::byte* in, std::byte* out,
                      size_t count, ElementType from, ElementType to) noexcept;
// To float32, from types for which fused_to_float() is true; keeps values in registers.
// (chain_float.cpp)
void run_chain_float(const ChainProgram& program, const std::byte* in, std::byte* out, size_t count,
                     ElementType from, ElementType to) noexcept;
bool fused_to_float(ElementType from, ElementType to) noexcept;

}  // namespace weir::transform
