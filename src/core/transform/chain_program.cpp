// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/chain_program.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/transform/number_rules.hpp"

namespace weir::transform {
namespace {

// x op neutral is x for every x.
template <class T>
T neutral(Operator op) noexcept {
  if (op != Operator::Add) return convert<T>(1.0f);
  if constexpr (std::integral<T>)
    return T{0};
  else
    return convert<T>(-0.0f);  // -0 + +0 is +0, so only adding -0 preserves both zeros
}

template <class T>
struct TypedColumn {
  Operator op;
  std::vector<T> operands;     // one for each channel
  std::vector<uint8_t> taken;  // 1: the channel has its operand
};

// A step joins the last column if the operation is the same and its channels have no operand there
// yet, so the order of operations on each element is kept.
template <class T>
std::vector<TypedColumn<T>> make_columns(std::span<const TypedStep> steps, size_t channels) {
  std::vector<TypedColumn<T>> columns;
  for (const auto& step : steps) {
    if (step.channel && *step.channel >= channels) continue;  // affects no element
    const size_t begin = step.channel ? *step.channel : 0;
    const size_t end = step.channel ? begin + 1 : channels;
    const auto is_taken = [&](const TypedColumn<T>& column) {
      const auto first = column.taken.begin();
      return std::any_of(first + static_cast<std::ptrdiff_t>(begin),
                         first + static_cast<std::ptrdiff_t>(end),
                         [](uint8_t t) { return t != 0; });
    };
    if (columns.empty() || columns.back().op != step.op || is_taken(columns.back()))
      columns.push_back({step.op, std::vector<T>(channels, neutral<T>(step.op)),
                         std::vector<uint8_t>(channels, 0)});
    auto& column = columns.back();
    for (size_t channel = begin; channel < end; ++channel) {
      column.operands[channel] = step.operand_as<T>();
      column.taken[channel] = 1;
    }
  }
  return columns;
}

// Expands one value per channel to one per element of the period, plus a block.
template <class T>
std::vector<std::byte> expand(const std::vector<T>& by_channel, size_t inner) {
  const size_t count = by_channel.size() * inner + kChainBlock;
  std::vector<std::byte> out(count * sizeof(T));
  for (size_t i = 0; i < count; ++i)
    std::memcpy(out.data() + i * sizeof(T), &by_channel[(i / inner) % by_channel.size()],
                sizeof(T));
  return out;
}

ColumnOp column_op(Operator op) noexcept {
  switch (op) {
    case Operator::Add:
      return ColumnOp::Add;
    case Operator::Mul:
      return ColumnOp::Mul;
    case Operator::Div:
      break;
  }
  return ColumnOp::Div;
}

struct Reciprocal {
  float high, low;
};

Reciprocal make_reciprocal(float divisor) noexcept {
  const double exact = 1.0 / static_cast<double>(divisor);
  const auto high = static_cast<float>(exact);
  return {high, static_cast<float>(exact - static_cast<double>(high))};
}

float apply(Operator op, float x, float operand) noexcept {
  switch (op) {
    case Operator::Add:
      return x + operand;
    case Operator::Mul:
      return x * operand;
    case Operator::Div:
      break;
  }
  return x / operand;
}

// Runs every possible value of a channel through the columns and clears exact[i] if the reciprocal
// gives other bits than the division of column i.
void check_reciprocals(std::span<const float> inputs,
                       const std::vector<TypedColumn<float>>& columns, size_t channel,
                       std::vector<bool>& exact) {
  for (const float input : inputs) {
    float x = input;
    for (size_t i = 0; i < columns.size(); ++i) {
      const float operand = columns[i].operands[channel];
      const float before = x;
      x = apply(columns[i].op, x, operand);
      if (columns[i].op != Operator::Div || !exact[i]) continue;
      const auto [high, low] = make_reciprocal(operand);
      const float fast = std::fma(before, high, before * low);
      exact[i] = std::bit_cast<uint32_t>(fast) == std::bit_cast<uint32_t>(x);
    }
  }
}

// Every value of an 8-bit or 16-bit integer type; empty for other types.
std::vector<float> all_values(ElementType type) {
  return visit_type(type, [](auto tag) {
    using T = typename decltype(tag)::type;
    std::vector<float> values;
    if constexpr (std::integral<T> && sizeof(T) <= 2)
      // NOLINTNEXTLINE(bugprone-signed-char-misuse): a number, whose sign stays
      for (auto x = static_cast<int32_t>(std::numeric_limits<T>::min());
           x <= std::numeric_limits<T>::max(); ++x)
        values.push_back(static_cast<float>(x));
    return values;
  });
}

// Selects the divisions that a reciprocal may replace.
std::vector<bool> exact_reciprocals(ElementType from,
                                    const std::vector<TypedColumn<float>>& columns) {
  constexpr size_t kWork = 1 << 20;  // more would delay the start too much
  std::vector<bool> exact(columns.size(), false);
  if (columns.empty()) return exact;
  const auto inputs = all_values(from);
  const size_t channels = columns[0].operands.size();
  if (inputs.empty() || inputs.size() * columns.size() > kWork / channels) return exact;
  exact.assign(columns.size(), true);
  for (size_t channel = 0; channel < channels; ++channel)
    check_reciprocals(inputs, columns, channel, exact);
  return exact;
}

void divide_by_reciprocals(ElementType from, const std::vector<TypedColumn<float>>& columns,
                           size_t inner, ChainProgram& program) {
  const auto exact = exact_reciprocals(from, columns);
  for (size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].op != Operator::Div || !exact[i]) continue;
    std::vector<float> high, low;
    for (const float operand : columns[i].operands) {
      const auto reciprocal = make_reciprocal(operand);
      high.push_back(reciprocal.high);
      low.push_back(reciprocal.low);
    }
    program.columns[i].op = ColumnOp::DivByReciprocal;
    program.columns[i].reciprocal_high = expand(high, inner);
    program.columns[i].reciprocal_low = expand(low, inner);
  }
}

}  // namespace

ChainProgram make_chain_program(ElementType from, ElementType to, std::span<const TypedStep> steps,
                                const Channels& channels) {
  ChainProgram program;
  program.period = channels.inner * channels.count;
  visit_type(to, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const auto columns = make_columns<T>(steps, channels.count);
    for (const auto& column : columns)
      program.columns.push_back(
          {column_op(column.op), expand(column.operands, channels.inner), {}, {}});
    if constexpr (std::same_as<T, float>)
      divide_by_reciprocals(from, columns, channels.inner, program);
  });
  return program;
}

}  // namespace weir::transform
