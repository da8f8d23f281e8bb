// One source for all vector widths: compiled once per CPU target.
#include "core/preprocess/row_kernels.hpp"

#include <algorithm>
#include <cstring>

#include "core/transform/float16_bits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/row_kernels.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;
static_assert(hn::MaxLanes(F()) <= kRowBlock);

V load_bytes(F d, const uint8_t* at) {
  const hn::Rebind<uint8_t, F> bytes;
  return hn::ConvertTo(d, hn::PromoteTo(I(), hn::LoadU(bytes, at)));
}

void BlendRows(const uint8_t* const* rows, const float* weights, size_t taps, size_t bytes,
               float* out) {
  const F d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  const auto whole = [&](auto value) {
    for (i = 0; i + lanes <= bytes; i += lanes) hn::StoreU(value(i), d, out + i);
  };
  const auto w0 = hn::Set(d, weights[0]);
  if (taps == 1) {
    whole([&](size_t at) { return load_bytes(d, rows[0] + at); });
  } else if (taps == 2) {
    const auto w1 = hn::Set(d, weights[1]);
    whole([&](size_t at) {
      return hn::MulAdd(w1, load_bytes(d, rows[1] + at), hn::Mul(w0, load_bytes(d, rows[0] + at)));
    });
  } else {
    whole([&](size_t at) {
      auto sum = hn::Mul(w0, load_bytes(d, rows[0] + at));
      for (size_t k = 1; k < taps; ++k)
        sum = hn::MulAdd(hn::Set(d, weights[k]), load_bytes(d, rows[k] + at), sum);
      return sum;
    });
  }
  for (; i < bytes; ++i) {
    float sum = taps == 1 ? static_cast<float>(rows[0][i]) : 0.0f;
    if (taps > 1)
      for (size_t k = 0; k < taps; ++k) sum += weights[k] * static_cast<float>(rows[k][i]);
    out[i] = sum;
  }
}

void GatherRow(const float* in, const int32_t* index, const float* weights, size_t taps,
               size_t count, float* out) {
  const F d;
  const I di;
  const size_t stride = padded(count);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    auto sum = hn::GatherIndex(d, in, hn::LoadU(di, index + i));
    if (taps > 1) sum = hn::Mul(sum, hn::LoadU(d, weights + i));
    for (size_t k = 1; k < taps; ++k) {
      const size_t at = k * stride + i;
      sum = hn::MulAdd(hn::LoadU(d, weights + at),
                       hn::GatherIndex(d, in, hn::LoadU(di, index + at)), sum);
    }
    hn::StoreU(sum, d, out + i);
  }
}

V pixel_range(F d, V v) {
  return hn::Min(hn::Max(v, hn::Zero(d)), hn::Set(d, 255.0f));
}

void TransformColors(const ColorTransform& t, float* const* rows, size_t count) {
  const F d;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto a = hn::LoadU(d, rows[0] + i);
    const auto b = hn::LoadU(d, rows[1] + i);
    const auto c = hn::LoadU(d, rows[2] + i);
    for (size_t r = 0; r < 3; ++r) {
      auto sum = hn::MulAdd(hn::Set(d, t.of[r][0]), a, hn::Set(d, t.add[r]));
      sum = hn::MulAdd(hn::Set(d, t.of[r][1]), b, sum);
      sum = hn::MulAdd(hn::Set(d, t.of[r][2]), c, sum);
      hn::StoreU(pixel_range(d, sum), d, rows[r] + i);
    }
  }
}

void TransformGray(float factor, float add, float* row, size_t count) {
  const F d;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto value = hn::MulAdd(hn::Set(d, factor), hn::LoadU(d, row + i), hn::Set(d, add));
    hn::StoreU(pixel_range(d, value), d, row + i);
  }
}

void MixToGray(const float* of, float* const* rows, size_t count) {
  const F d;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    auto sum = hn::Mul(hn::Set(d, of[0]), hn::LoadU(d, rows[0] + i));
    sum = hn::MulAdd(hn::Set(d, of[1]), hn::LoadU(d, rows[1] + i), sum);
    sum = hn::MulAdd(hn::Set(d, of[2]), hn::LoadU(d, rows[2] + i), sum);
    hn::StoreU(sum, d, rows[0] + i);
  }
}

// Subtracted, then multiplied: the same roundings as tensor_transform's add and mul.
V number(F d, const NumberRule& rule, const float* at) {
  return hn::Mul(hn::Sub(hn::LoadU(d, at), hn::Set(d, rule.mean)), hn::Set(d, rule.scale));
}

// Calls vector(i) for the whole vectors of `count` numbers, each of which stores a vector at the
// place it is given, and one for the rest, of which no more than the rest goes out.
template <class T, class Store>
void store_exactly(size_t lanes, size_t step, size_t count, T* out, Store&& vector) {
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) vector(i, out + step * i);
  if (i == count) return;
  T rest[3 * hn::MaxLanes(hn::ScalableTag<T>())];
  vector(i, rest);
  std::memcpy(static_cast<void*>(out + step * i), rest, step * (count - i) * sizeof(T));
}

// Past the caches, but for the ends of the row, which share their vectors with its neighbours.
template <class Make>
void stream_floats(F d, size_t count, float* out, Make&& make) {
  const size_t lanes = hn::Lanes(d);
  const size_t behind = reinterpret_cast<uintptr_t>(out) / sizeof(float) % lanes;
  const size_t head = std::min(count, behind > 0 ? lanes - behind : 0);
  const auto part = [&](size_t begin, size_t end) {
    if (begin == end) return;
    const size_t from = end < lanes ? 0 : end - lanes;  // nothing behind the row is read
    float numbers[hn::MaxLanes(F())];
    hn::StoreU(make(from), d, numbers);
    std::memcpy(out + begin, numbers + (begin - from), (end - begin) * sizeof(float));
  };
  part(0, head);
  size_t i = head;
  for (; i + lanes <= count; i += lanes) hn::Stream(make(i), d, out + i);
  part(i, count);
}

template <class T>
void write_integers(const NumberRule& rule, const float* row, size_t count, T* out) {
  const F d;
  const I di;
  const hn::Rebind<T, F> bytes;
  const auto bound = hn::Set(d, 65536.0f);
  store_exactly(hn::Lanes(d), 1, count, out, [&](size_t i, T* to) {
    const auto value = hn::Div(number(d, rule, row + i), hn::Set(d, rule.divisor));
    const auto near = hn::Max(hn::Min(value, bound), hn::Neg(bound));
    const auto rounded = hn::Add(hn::NearestInt(near), hn::Set(di, rule.zero_point));
    hn::StoreU(hn::DemoteTo(bytes, rounded), bytes, to);
  });
}

void WriteNumbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                  void* out, bool streamed) {
  const F d;
  if (type == ElementType::UInt8)
    return write_integers(rule, row, count, static_cast<uint8_t*>(out));
  if (type == ElementType::Int8) return write_integers(rule, row, count, static_cast<int8_t*>(out));
  if (streamed && type == ElementType::Float32 && reinterpret_cast<uintptr_t>(out) % 4 == 0)
    return stream_floats(d, count, static_cast<float*>(out),
                         [&](size_t i) { return number(d, rule, row + i); });
  if (type == ElementType::Float32)
    return store_exactly(hn::Lanes(d), 1, count, static_cast<float*>(out),
                         [&](size_t i, float* to) { hn::StoreU(number(d, rule, row + i), d, to); });
  float16 halves[kRowBlock];
  for (size_t i = 0; i < count; i += kRowBlock) {
    for (size_t k = 0; k < kRowBlock; ++k)
      halves[k] = transform::round_to_half((row[i + k] - rule.mean) * rule.scale);
    std::memcpy(static_cast<std::byte*>(out) + i * sizeof(float16), halves,
                std::min(kRowBlock, count - i) * sizeof(float16));
  }
}

template <class T>
void interleave(const void* const* rows, size_t count, void* out) {
  const hn::ScalableTag<T> d;
  const T* a = static_cast<const T*>(rows[0]);
  const T* b = static_cast<const T*>(rows[1]);
  const T* c = static_cast<const T*>(rows[2]);
  store_exactly(hn::Lanes(d), 3, count, static_cast<T*>(out), [&](size_t i, T* to) {
    hn::StoreInterleaved3(hn::LoadU(d, a + i), hn::LoadU(d, b + i), hn::LoadU(d, c + i), d, to);
  });
}
static_assert(hn::MaxLanes(hn::ScalableTag<uint8_t>()) <= kRowBlock);

void InterleaveThree(const void* const* rows, size_t element_bytes, size_t count, void* out) {
  if (element_bytes == 1) return interleave<uint8_t>(rows, count, out);
  if (element_bytes == 2) return interleave<uint16_t>(rows, count, out);
  interleave<uint32_t>(rows, count, out);
}

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(BlendRows);
HWY_EXPORT(GatherRow);
HWY_EXPORT(TransformColors);
HWY_EXPORT(TransformGray);
HWY_EXPORT(MixToGray);
HWY_EXPORT(WriteNumbers);
HWY_EXPORT(InterleaveThree);

void blend_rows(const uint8_t* const* rows, const float* weights, size_t taps, size_t bytes,
                float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(BlendRows)(rows, weights, taps, bytes, out);
}
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(GatherRow)(in, index, weights, taps, count, out);
}
void transform_colors(const ColorTransform& transform, float* const* rows, size_t count) noexcept {
  HWY_DYNAMIC_DISPATCH(TransformColors)(transform, rows, count);
}
void transform_gray(float factor, float add, float* row, size_t count) noexcept {
  HWY_DYNAMIC_DISPATCH(TransformGray)(factor, add, row, count);
}
void mix_to_gray(const float* of, float* const* rows, size_t count) noexcept {
  HWY_DYNAMIC_DISPATCH(MixToGray)(of, rows, count);
}
void write_numbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                   void* out, bool streamed) noexcept {
  HWY_DYNAMIC_DISPATCH(WriteNumbers)(rule, type, row, count, out, streamed);
}
void end_streaming() noexcept {
  hwy::FlushStream();
}
void interleave_three(const void* const* rows, size_t element_bytes, size_t count,
                      void* out) noexcept {
  HWY_DYNAMIC_DISPATCH(InterleaveThree)(rows, element_bytes, count, out);
}

}  // namespace weir::preprocess
#endif
