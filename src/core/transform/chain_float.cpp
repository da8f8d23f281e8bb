// Chains to float32 from small integers and floats: load, convert, all columns and store, entirely
// in registers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/transform/chain_program.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/chain_float.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#include "core/transform/load_floats-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A group of this many vectors fits into a block on every CPU.
constexpr size_t kGroup = 12;
using FloatTag = hn::CappedTag<float, 16>;
using FloatVec = hn::Vec<FloatTag>;
static_assert(kGroup * 16 <= kChainBlock);

// The operands of a column as floats, from element `phase` of the period on.
struct FloatColumn {
  ColumnOp op;
  const float* operands;
  const float* high;
  const float* low;
  size_t phase;

  FloatColumn(const Column& column, size_t from) noexcept
      : op(column.op),
        operands(reinterpret_cast<const float*>(column.operands.data())),
        high(reinterpret_cast<const float*>(column.reciprocal_high.data())),
        low(reinterpret_cast<const float*>(column.reciprocal_low.data())),
        phase(from) {}
};

// Twelve vectors at a time hide the latency of each operation and the cost of selecting it.
struct FloatGroup {
  FloatVec a, b, c, d, e, f, g, h, i, j, k, l;

  // change(vector, its number)
  template <class F>
  HWY_INLINE void each(F&& change) noexcept {
    a = change(a, 0);
    b = change(b, 1);
    c = change(c, 2);
    d = change(d, 3);
    e = change(e, 4);
    f = change(f, 5);
    g = change(g, 6);
    h = change(h, 7);
    i = change(i, 8);
    j = change(j, 9);
    k = change(k, 10);
    l = change(l, 11);
  }
};

// kRepeat: the operands repeat after this many vectors, which divides a group, and each is loaded
// once. 0: another period, so each vector loads its own operands.
template <size_t kRepeat>
HWY_INLINE FloatVec operand_at(const float* operands, size_t vector) noexcept {
  const FloatTag df;
  if constexpr (kRepeat > 0) vector %= kRepeat;
  return hn::LoadU(df, operands + vector * hn::Lanes(df));
}

template <size_t kRepeat>
HWY_INLINE void run_column(const FloatColumn& column, FloatGroup& x) noexcept {
  const auto at = [&column](const float* operands, size_t vector)
                      HWY_ATTR { return operand_at<kRepeat>(operands + column.phase, vector); };
  switch (column.op) {
    case ColumnOp::Add:
      x.each([&](auto v, size_t n) HWY_ATTR { return hn::Add(v, at(column.operands, n)); });
      return;
    case ColumnOp::Mul:
      x.each([&](auto v, size_t n) HWY_ATTR { return hn::Mul(v, at(column.operands, n)); });
      return;
    case ColumnOp::DivByReciprocal:
#if HWY_NATIVE_FMA
      x.each([&](auto v, size_t n) HWY_ATTR {
        return hn::MulAdd(v, at(column.high, n), hn::Mul(v, at(column.low, n)));
      });
      return;
#endif  // without it the sum would be rounded twice
    case ColumnOp::Div:
      break;
  }
  x.each([&](auto v, size_t n) HWY_ATTR { return hn::Div(v, at(column.operands, n)); });
}

// Processes one group. kStreamed: non-temporal stores; `out` is aligned to a vector.
template <class From, size_t kRepeat, bool kStreamed>
HWY_INLINE void run_group(const ChainProgram& program, size_t phase, const From* in,
                          float* out) noexcept {
  const FloatTag df;
  const size_t lanes = hn::Lanes(df);
  const auto at = [&](size_t n) HWY_ATTR { return load_floats(df, in + n * lanes); };
  FloatGroup x{at(0), at(1), at(2), at(3), at(4),  at(5),
               at(6), at(7), at(8), at(9), at(10), at(11)};
  for (const auto& column : program.columns) run_column<kRepeat>(FloatColumn(column, phase), x);
  x.each([&](auto v, size_t n) HWY_ATTR {
    store_floats<kStreamed>(v, df, out + n * lanes);
    return v;
  });
}

// The elements after the last whole group. Compiled once for both kinds of stores.
template <class From, size_t kRepeat>
HWY_NOINLINE void run_rest(const ChainProgram& program, size_t phase, const std::byte* in,
                           std::byte* out, size_t count) noexcept {
  alignas(64) From source[kChainBlock] = {};
  alignas(64) float values[kChainBlock];
  std::memcpy(source, in, count * sizeof(From));
  run_group<From, kRepeat, false>(program, phase, source, values);
  std::memcpy(out, values, count * sizeof(float));
}

template <class From, size_t kRepeat, bool kStreamed>
void run_groups(const ChainProgram& program, const std::byte* in_bytes, std::byte* out_bytes,
                size_t count) noexcept {
  // Highway's loads and stores are unaligned; the cast pointers are never dereferenced directly.
  const From* in = reinterpret_cast<const From*>(in_bytes);
  float* out = reinterpret_cast<float*>(out_bytes);
  const size_t group = kGroup * hn::Lanes(FloatTag());
  const size_t advance = group % program.period;  // 0 if kRepeat is not
  size_t phase = 0;
  size_t i = 0;
  for (; count - i >= group; i += group) {
    run_group<From, kRepeat, kStreamed>(program, phase, in + i, out + i);
    if constexpr (kRepeat == 0) {
      phase += advance;
      if (phase >= program.period) phase -= program.period;
    }
  }
  if constexpr (kStreamed) hwy::FlushStream();
  if (i < count)
    run_rest<From, kRepeat>(program, phase, in_bytes + i * sizeof(From),
                            out_bytes + i * sizeof(float), count - i);
}

template <class From, size_t kRepeat>
void run_typed(const ChainProgram& program, const std::byte* in, std::byte* out,
               size_t count) noexcept {
  if (worth_streaming(FloatTag(), in, reinterpret_cast<const float*>(out), count))
    run_groups<From, kRepeat, true>(program, in, out, count);
  else
    run_groups<From, kRepeat, false>(program, in, out, count);
}

template <class From>
void run_from(const ChainProgram& program, const std::byte* in, std::byte* out,
              size_t count) noexcept {
  const size_t vectors = program.period / std::gcd(program.period, hn::Lanes(FloatTag()));
  if (vectors == 1) return run_typed<From, 1>(program, in, out, count);
  if (vectors == 3) return run_typed<From, 3>(program, in, out, count);
  run_typed<From, 0>(program, in, out, count);
}

void RunFloat(const ChainProgram& program, const std::byte* in, std::byte* out, size_t count,
              ElementType from) {
  visit_type(from, [&](auto tag) HWY_ATTR {
    using From = typename decltype(tag)::type;
    if constexpr (std::is_same_v<From, float> || (std::is_integral_v<From> && sizeof(From) <= 2) ||
                  std::is_same_v<From, int32_t>)
      run_from<From>(program, in, out, count);
  });
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunFloat);

bool fused_to_float(ElementType from, ElementType to) noexcept {
  if (to != ElementType::Float32) return false;
  return element_size(from) == 1 || from == ElementType::Int16 || from == ElementType::UInt16 ||
         from == ElementType::Int32 || from == ElementType::Float32;
}

void run_chain_float(const ChainProgram& program, const std::byte* in, std::byte* out, size_t count,
                     ElementType from, ElementType /*to*/) noexcept {
  HWY_DYNAMIC_DISPATCH(RunFloat)(program, in, out, count, from);
}

}  // namespace weir::transform
#endif
