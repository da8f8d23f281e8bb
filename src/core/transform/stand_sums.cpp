// Mean and deviation of a few channels in one pass over memory. A row is one vector for each
// channel, so that its positions belong to the same channels in every row. For each phase, the
// vectors of a block of rows, which stays in the cache, are added up in registers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/simd/dispatch.hpp"
#include "core/transform/stand_scale.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/stand_sums.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

// Compiled once: the results do not depend on the CPU and are combined once per tensor.
#ifndef WEIR_STAND_SUMS_ONCE
#define WEIR_STAND_SUMS_ONCE
namespace weir::transform {

__extension__ using WideSum = unsigned __int128;

// Sums of unsigned numbers; signed ones were shifted up by half their range.
struct IntegerSums {
  WideSum sum[kFewChannels] = {}, squares[kFewChannels] = {};
};

// Sums of distances from `from`.
struct FloatSums {
  double from[kFewChannels] = {}, sum[kFewChannels] = {}, squares[kFewChannels] = {};
};

}  // namespace weir::transform
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The largest number of positions in a row.
constexpr size_t kMaxPositions = kFewChannels * 32;
constexpr size_t kBlockBytes = size_t{16} * 1024;

// T is unsigned. Squares of T fit into Wide; kRows of their upper halves and of T itself can be
// added.
template <class T>
struct IntegerLanes {
  using Wide = hwy::MakeWide<T>;
  using WideTag = hn::CappedTag<Wide, 32>;
  static constexpr size_t kRows = 257;
  static constexpr int kHalf = sizeof(T) * 8;
};

// Adds the vectors at `in`, `stride` apart, position by position.
template <class T, bool kSigned>
HWY_INLINE void add_vectors(const T* in, size_t stride, size_t rows, uint64_t* sums,
                            uint64_t* squares) noexcept {
  using Lanes = IntegerLanes<T>;
  using Wide = typename Lanes::Wide;
  const typename Lanes::WideTag dw;
  const hn::Rebind<T, decltype(dw)> dt;
  const auto turned = hn::Set(dw, static_cast<Wide>(Wide{1} << (Lanes::kHalf - 1)));
  auto sum = hn::Zero(dw), wrapped = hn::Zero(dw), high = hn::Zero(dw);
  for (size_t row = 0; row < rows; ++row, in += stride) {
    auto x = hn::PromoteTo(dw, hn::LoadU(dt, in));
    if constexpr (kSigned) x = hn::Xor(x, turned);
    const auto square = hn::Mul(x, x);
    sum = hn::Add(sum, x);
    wrapped = hn::Add(wrapped, square);
    high = hn::Add(high, hn::ShiftRight<Lanes::kHalf>(square));
  }
  alignas(64) Wide parts[3][32];
  hn::Store(sum, dw, parts[0]);
  hn::Store(wrapped, dw, parts[1]);
  hn::Store(high, dw, parts[2]);
  for (size_t i = 0; i < hn::Lanes(dw); ++i) {
    sums[i] += parts[0][i];
    // The lower halves sum to less than a Wide, namely the wrapped sum minus the upper halves.
    const uint64_t above = uint64_t{parts[2][i]} << Lanes::kHalf;
    squares[i] += above + static_cast<Wide>(parts[1][i] - above);
  }
}

template <class T, bool kSigned>
void add_integers(const StandTensor& tensor, const std::byte* bytes, IntegerSums& totals) noexcept {
  using Lanes = IntegerLanes<T>;
  const T* in = reinterpret_cast<const T*>(bytes);  // never dereferenced: Highway loads and memcpy
  const size_t lanes = hn::Lanes(typename Lanes::WideTag());
  const size_t row = tensor.channels * lanes, rows = tensor.count / row;
  const size_t block = std::clamp<size_t>(kBlockBytes / (row * sizeof(T)), 16, Lanes::kRows);
  uint64_t sums[kMaxPositions] = {}, squares[kMaxPositions] = {};
  for (size_t done = 0; done < rows; done += block)
    for (size_t phase = 0; phase < tensor.channels; ++phase)
      add_vectors<T, kSigned>(in + done * row + phase * lanes, row, std::min(block, rows - done),
                              sums + phase * lanes, squares + phase * lanes);
  for (size_t i = rows * row; i < tensor.count; ++i) {
    T x;
    std::memcpy(&x, in + i, sizeof(T));
    if constexpr (kSigned) x = static_cast<T>(x ^ (1U << (Lanes::kHalf - 1)));
    sums[i - rows * row] += x;
    squares[i - rows * row] += uint64_t{x} * x;
  }
  for (size_t i = 0; i < row; ++i) {
    totals.sum[i % tensor.channels] += sums[i];
    totals.squares[i % tensor.channels] += squares[i];
  }
}

#if HWY_TARGET != HWY_SCALAR
// For one channel, where positions need not be separated: sums of eight bytes at a time, and
// squares of the even and the odd bytes, added in pairs.
template <bool kSigned>
void add_bytes(const std::byte* bytes, size_t count, IntegerSums& totals) noexcept {
  const hn::ScalableTag<uint8_t> d;
  const hn::RepartitionToWide<decltype(d)> d16;
  const hn::RebindToSigned<decltype(d16)> di16;
  const hn::RepartitionToWide<decltype(di16)> d32;
  const hn::Repartition<uint64_t, decltype(d)> d64;
  constexpr size_t kVectors = 8192;  // times 2 * 255^2 fit into a lane of 31 bits
  const auto* in = reinterpret_cast<const uint8_t*>(bytes);
  const size_t lanes = hn::Lanes(d), whole = count / lanes;
  const auto turned = hn::Set(d, uint8_t{0x80});
  const auto low = hn::Set(d16, uint16_t{0xFF});
  auto sum = hn::Zero(d64);
  uint64_t squares_total = 0;
  for (size_t done = 0; done < whole; done += kVectors) {
    auto even = hn::Zero(d32), odd = hn::Zero(d32), even_rest = hn::Zero(d32),
         odd_rest = hn::Zero(d32);
    const size_t end = std::min(done + kVectors, whole);
    for (size_t i = done; i < end; ++i) {
      auto x = hn::LoadU(d, in + i * lanes);
      if constexpr (kSigned) x = hn::Xor(x, turned);
      sum = hn::Add(sum, hn::SumsOf8(x));
      const auto pairs = hn::BitCast(d16, x);
      const auto a = hn::BitCast(di16, hn::And(pairs, low));
      const auto b = hn::BitCast(di16, hn::ShiftRight<8>(pairs));
      even = hn::ReorderWidenMulAccumulate(d32, a, a, even, even_rest);
      odd = hn::ReorderWidenMulAccumulate(d32, b, b, odd, odd_rest);
    }
    for (const auto& part : {even, odd, even_rest, odd_rest}) {
      alignas(64) int32_t each[HWY_MAX_BYTES / sizeof(int32_t)];
      hn::Store(part, d32, each);
      for (size_t i = 0; i < hn::Lanes(d32); ++i) squares_total += static_cast<uint32_t>(each[i]);
    }
  }
  uint64_t total = hn::GetLane(hn::SumOfLanes(d64, sum));
  for (size_t i = whole * lanes; i < count; ++i) {
    const auto x = static_cast<uint8_t>(in[i] ^ (kSigned ? 0x80 : 0));
    total += x;
    squares_total += uint64_t{x} * x;
  }
  totals.sum[0] += total;
  totals.squares[0] += squares_total;
}
#endif

// The same number of positions per phase on every CPU, so that sums are rounded equally. Vectors
// have at most 256 bits: AVX-512 needs twice the time on Zen 4, and more vectors hide the latency
// of additions. As many at once as there are registers for their two sums.
constexpr size_t kPositions = 32;
constexpr size_t kLanes = HWY_MIN(HWY_LANES(double), 4);
constexpr size_t kVectors = HWY_TARGET <= HWY_AVX3 ? 8 : 4;
constexpr size_t kAtOnce = kVectors * kLanes;
static_assert(kPositions % kAtOnce == 0);
using DoubleTag = hn::FixedTag<double, kLanes>;
// CPUs with FMA convert and add in the same units but multiply in others, so half of the additions
// are computed there as sum + x * 1, with the same result.
constexpr bool kAddsByProduct = HWY_NATIVE_FMA != 0;

// kFromZero: sums the elements themselves. The square of a float32 is exact in double, so one
// rounding or two give the same sum.
template <bool kFromZero>
HWY_INLINE void add_float_vectors(const float* in, size_t stride, size_t rows, const double* from,
                                  double* sums, double* squares) noexcept {
  const DoubleTag d;
  const hn::Rebind<float, DoubleTag> df;
  const auto one = hn::Set(d, 1.0);
  hn::Vec<DoubleTag> sum[kVectors], square[kVectors];
  HWY_UNROLL(32)
  for (size_t i = 0; i < kVectors; ++i) sum[i] = square[i] = hn::Zero(d);
  for (size_t row = 0; row < rows; ++row, in += stride) {
    HWY_UNROLL(32)
    for (size_t i = 0; i < kVectors; ++i) {
      auto x = hn::PromoteTo(d, hn::LoadU(df, in + i * kLanes));
      if constexpr (kFromZero) {
        square[i] = hn::MulAdd(x, x, square[i]);
      } else {
        x = hn::Sub(x, hn::LoadU(d, from + i * kLanes));
        square[i] = hn::Add(square[i], hn::Mul(x, x));
      }
      sum[i] = kAddsByProduct && i % 2 == 0 ? hn::MulAdd(x, one, sum[i]) : hn::Add(sum[i], x);
    }
  }
  HWY_UNROLL(32)
  for (size_t i = 0; i < kVectors; ++i) {
    const size_t at = i * kLanes;
    hn::StoreU(hn::Add(hn::LoadU(d, sums + at), sum[i]), d, sums + at);
    hn::StoreU(hn::Add(hn::LoadU(d, squares + at), square[i]), d, squares + at);
  }
}

template <bool kFromZero>
void add_floats(const StandTensor& tensor, const std::byte* bytes, FloatSums& totals) noexcept {
  const float* in = reinterpret_cast<const float*>(bytes);  // never dereferenced directly
  const size_t row = tensor.channels * kPositions, rows = tensor.count / row;
  const size_t block = std::max<size_t>(kBlockBytes / (row * sizeof(float)), 16);
  double from[kFewChannels * kPositions],
      sums[kFewChannels * kPositions] = {}, squares[kFewChannels * kPositions] = {};
  for (size_t i = 0; i < row; ++i) from[i] = totals.from[i % tensor.channels];
  for (size_t done = 0; done < rows; done += block)
    for (size_t at = 0; at < row; at += kAtOnce)
      add_float_vectors<kFromZero>(in + done * row + at, row, std::min(block, rows - done),
                                   from + at, sums + at, squares + at);
  for (size_t i = rows * row; i < tensor.count; ++i) {
    float element;
    std::memcpy(&element, in + i, sizeof(float));
    const size_t at = i - rows * row;
    const double x = static_cast<double>(element) - from[at];
    sums[at] += x;
    squares[at] += x * x;
  }
  for (size_t i = 0; i < row; ++i) {
    totals.sum[i % tensor.channels] += sums[i];
    totals.squares[i % tensor.channels] += squares[i];
  }
}

void AddIntegers(const StandTensor& tensor, ElementType type, const std::byte* in,
                 IntegerSums& totals) {
#if HWY_TARGET != HWY_SCALAR
  if (tensor.channels == 1 && element_size(type) == 1)
    return type == ElementType::Int8 ? add_bytes<true>(in, tensor.count, totals)
                                     : add_bytes<false>(in, tensor.count, totals);
#endif
  if (type == ElementType::UInt8) return add_integers<uint8_t, false>(tensor, in, totals);
  if (type == ElementType::Int8) return add_integers<uint8_t, true>(tensor, in, totals);
  if (type == ElementType::UInt16) return add_integers<uint16_t, false>(tensor, in, totals);
  add_integers<uint16_t, true>(tensor, in, totals);
}

void AddFloats(const StandTensor& tensor, const std::byte* in, FloatSums& totals) {
  const auto* from = std::begin(totals.from);
  if (std::all_of(from, from + tensor.channels, [](double x) { return x == 0; }))
    add_floats<true>(tensor, in, totals);
  else
    add_floats<false>(tensor, in, totals);
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {
namespace {

HWY_EXPORT(AddIntegers);
HWY_EXPORT(AddFloats);

StandScale measure_integers(const StandTensor& tensor, ElementType type, bool accelerate,
                            const std::byte* in) noexcept {
  IntegerSums sums;
  WEIR_DISPATCH_IF(accelerate, AddIntegers)(tensor, type, in, sums);
  const bool is_signed = type == ElementType::Int8 || type == ElementType::Int16;
  const int64_t up = is_signed ? int64_t{1} << (element_size(type) * 8 - 1) : 0;
  const size_t n = tensor.count / tensor.channels;
  const auto number = static_cast<double>(n);
  StandScale scale;
  for (size_t i = 0; i < tensor.channels; ++i) {
    const auto sum = static_cast<int64_t>(sums.sum[i]) - up * static_cast<int64_t>(n);
    scale.mean[i] = static_cast<double>(sum) / number;
    // n sum(x^2) - sum(x)^2 is n^2 times the variance, without rounding error.
    const WideSum spread = sums.squares[i] * n - sums.sum[i] * sums.sum[i];
    scale.deviation[i] = stand_deviation(static_cast<double>(spread) / number / number);
  }
  return scale;
}

void add_floats(const StandTensor& tensor, bool accelerate, const std::byte* in,
                FloatSums& sums) noexcept {
  WEIR_DISPATCH_IF(accelerate, AddFloats)(tensor, in, sums);
}

// First sums from zero, which loses the digits of a deviation that is small compared to the mean;
// in that case sums again from the mean.
StandScale measure_floats(const StandTensor& tensor, bool accelerate,
                          const std::byte* in) noexcept {
  constexpr double kKept = 0x1p-12;
  FloatSums sums;
  const size_t elements = tensor.count / tensor.channels;
  const auto n = static_cast<double>(elements);
  StandScale scale;
  for (const bool first : {true, false}) {
    add_floats(tensor, accelerate, in, sums);
    bool lost = false;
    for (size_t i = 0; i < tensor.channels; ++i) {
      const double moved = sums.sum[i] / n, square = sums.squares[i] / n;
      const double variance = square - moved * moved;
      scale.mean[i] = sums.from[i] + moved;
      scale.deviation[i] = stand_deviation(variance < 0 ? 0 : variance);
      lost = lost || variance < kKept * square;
    }
    if (!lost || !first) break;
    sums = {};
    std::copy(std::begin(scale.mean), std::end(scale.mean), std::begin(sums.from));
  }
  return scale;
}

}  // namespace

double stand_deviation(double variance) noexcept {
  if (variance > 0) return std::sqrt(variance);
  return variance == 0 ? 1e-10 : variance;  // NaN stays
}

bool measures_few(const StandTensor& tensor, ElementType from) noexcept {
  if (tensor.channels > kFewChannels) return false;
  return element_size(from) == 1 || from == ElementType::Int16 || from == ElementType::UInt16 ||
         from == ElementType::Float32;
}

StandScale measure_few(const StandTensor& tensor, const StandTypes& types, bool accelerate,
                       const std::byte* in) noexcept {
  if (types.from == ElementType::Float32) return measure_floats(tensor, accelerate, in);
  return measure_integers(tensor, types.from, accelerate, in);
}

}  // namespace weir::transform
#endif
