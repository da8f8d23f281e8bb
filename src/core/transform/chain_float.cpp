// Chains to float32 from small integers and floats: load, convert, all columns, store, with nothing
// but registers between.
#include <algorithm>
#include <cstring>

#include "core/transform/chain_program.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/chain_float.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A group of these fits a block, however long the vectors of the CPU are.
constexpr size_t kGroup = 8;
using FloatTag = hn::CappedTag<float, kChainBlock / kGroup>;
using FloatVec = hn::Vec<FloatTag>;

// A vector of floats from as many elements of another type.
template <class From>
FloatVec load_floats(const From* from) noexcept {
  const FloatTag df;
  if constexpr (std::is_same_v<From, float>) {
    return hn::LoadU(df, from);
  } else if constexpr (std::is_same_v<From, int32_t>) {
    return hn::ConvertTo(df, hn::LoadU(hn::Rebind<int32_t, FloatTag>(), from));
  } else {
    const hn::Rebind<int32_t, FloatTag> di;
    return hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(hn::Rebind<From, FloatTag>(), from)));
  }
}

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

// Eight vectors at a time hide the latency of each operation, and what choosing it costs.
struct FloatGroup {
  FloatVec a, b, c, d, e, f, g, h;

  template <class F>
  HWY_INLINE void each(size_t lanes, F&& change) noexcept {
    a = change(a, 0);
    b = change(b, lanes);
    c = change(c, 2 * lanes);
    d = change(d, 3 * lanes);
    e = change(e, 4 * lanes);
    f = change(f, 5 * lanes);
    g = change(g, 6 * lanes);
    h = change(h, 7 * lanes);
  }
};

// kUniform: every element has the operand at 0, else element i that at i.
template <bool kUniform>
HWY_INLINE FloatVec operand_at(const float* operands, size_t i) noexcept {
  const FloatTag df;
  if constexpr (kUniform)
    return hn::Set(df, operands[0]);
  else
    return hn::LoadU(df, operands + i);
}

template <bool kUniform>
HWY_INLINE void run_column(const FloatColumn& column, size_t lanes, FloatGroup& x) noexcept {
  const auto at = [&column](const float* operands, size_t i)
                      HWY_ATTR { return operand_at<kUniform>(operands, column.phase + i); };
  switch (column.op) {
    case ColumnOp::Add:
      x.each(lanes, [&](auto v, size_t i) HWY_ATTR { return hn::Add(v, at(column.operands, i)); });
      return;
    case ColumnOp::Mul:
      x.each(lanes, [&](auto v, size_t i) HWY_ATTR { return hn::Mul(v, at(column.operands, i)); });
      return;
    case ColumnOp::DivByReciprocal:
#if HWY_NATIVE_FMA
      x.each(lanes, [&](auto v, size_t i) HWY_ATTR {
        return hn::MulAdd(v, at(column.high, i), hn::Mul(v, at(column.low, i)));
      });
      return;
#endif  // without it the sum would be rounded twice
    case ColumnOp::Div:
      break;
  }
  x.each(lanes, [&](auto v, size_t i) HWY_ATTR { return hn::Div(v, at(column.operands, i)); });
}

// `length` elements, a multiple of kGroup vectors and at most kChainBlock.
template <class From, bool kUniform>
HWY_INLINE void run_floats(const ChainProgram& program, size_t phase, const From* in, float* out,
                           size_t length) noexcept {
  const FloatTag df;
  const size_t lanes = hn::Lanes(df);
  for (size_t i = 0; i < length; i += kGroup * lanes) {
    FloatGroup x{load_floats(in + i),
                 load_floats(in + i + lanes),
                 load_floats(in + i + 2 * lanes),
                 load_floats(in + i + 3 * lanes),
                 load_floats(in + i + 4 * lanes),
                 load_floats(in + i + 5 * lanes),
                 load_floats(in + i + 6 * lanes),
                 load_floats(in + i + 7 * lanes)};
    for (const auto& column : program.columns)
      run_column<kUniform>(FloatColumn(column, kUniform ? 0 : phase + i), lanes, x);
    x.each(lanes, [&](auto v, size_t at) HWY_ATTR {
      hn::StoreU(v, df, out + i + at);
      return v;
    });
  }
}

template <class From, bool kUniform>
void run_typed(const ChainProgram& program, const std::byte* in_bytes, std::byte* out_bytes,
               size_t count) noexcept {
  // Highway's unaligned loads and stores: the pointers are never read through as they are.
  const From* in = reinterpret_cast<const From*>(in_bytes);
  float* out = reinterpret_cast<float*>(out_bytes);
  size_t phase = 0;
  size_t i = 0;
  for (; count - i >= kChainBlock; i += kChainBlock) {
    run_floats<From, kUniform>(program, phase, in + i, out + i, kChainBlock);
    if constexpr (!kUniform) phase = (phase + kChainBlock) % program.period;
  }
  const size_t rest = count - i;
  if (rest == 0) return;
  alignas(64) From source[kChainBlock];
  alignas(64) float values[kChainBlock];
  const size_t group = kGroup * hn::Lanes(FloatTag());
  const size_t padded = (rest + group - 1) / group * group;
  std::fill(source + rest, source + padded, From{});
  std::memcpy(source, in_bytes + i * sizeof(From), rest * sizeof(From));
  run_floats<From, kUniform>(program, phase, source, values, padded);
  std::memcpy(out_bytes + i * sizeof(float), values, rest * sizeof(float));
}

template <class From>
void run_from(const ChainProgram& program, const std::byte* in, std::byte* out,
              size_t count) noexcept {
  if (program.period == 1)
    run_typed<From, true>(program, in, out, count);
  else
    run_typed<From, false>(program, in, out, count);
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
  return size_of(from) == 1 || from == ElementType::Int16 || from == ElementType::UInt16 ||
         from == ElementType::Int32 || from == ElementType::Float32;
}

void run_chain_float(const ChainProgram& program, const std::byte* in, std::byte* out, size_t count,
                     ElementType from, ElementType /*to*/) noexcept {
  HWY_DYNAMIC_DISPATCH(RunFloat)(program, in, out, count, from);
}

}  // namespace weir::transform
#endif
