// Mixes bytes of even and odd places apart, as numbers of 16 bits. Three vectors are a whole number
// of patterns.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/tint_row.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/draw/tint_row.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::draw::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR
// Mixes with vectors of one size, in turn with those of the places where they begin.
template <class D8>
class Mixer {
  using D = hn::Repartition<uint16_t, D8>;
  using V = hn::Vec<D>;

 public:
  Mixer(D8 d8, uint8_t opacity)
      : d8_(d8),
        low_(hn::Set(d_, uint16_t{0xFF})),
        high_(hn::Set(d_, uint16_t{0xFF00})),
        share_(hn::Set(d_, opacity)),
        rest_(hn::Set(d_, static_cast<uint16_t>(255 - opacity))),
        half_(hn::Set(d_, uint16_t{128})) {}

  // The colour's part of the bytes at even and odd places.
  struct Part {
    V even, odd;
  };
  Part part(const uint8_t* pattern) const {
    const auto both = load(pattern);
    return {hn::Add(hn::Mul(hn::And(both, low_), share_), half_),
            hn::Add(hn::Mul(hn::ShiftRight<8>(both), share_), half_)};
  }
  V mix(const uint8_t* from, const Part& part) const {
    const auto both = load(from);
    const auto even = over_255(hn::Add(hn::Mul(hn::And(both, low_), rest_), part.even));
    const auto odd = over_255(hn::Add(hn::Mul(hn::ShiftRight<8>(both), rest_), part.odd));
    return hn::Or(hn::ShiftRight<8>(even), hn::And(odd, high_));
  }
  void store(V mixed, uint8_t* to) const { hn::StoreU(hn::BitCast(d8_, mixed), d8_, to); }

 private:
  V load(const uint8_t* from) const { return hn::BitCast(d_, hn::LoadU(d8_, from)); }
  static V over_255(V sum) { return hn::Add(sum, hn::ShiftRight<8>(sum)); }

  D8 d8_;
  D d_;
  V low_, high_, share_, rest_, half_;
};

// Precondition: `bytes` is at least the size of a vector.
template <class D8>
void tint_with(D8 d8, uint8_t* row, uint8_t opacity, size_t bytes, const uint8_t* pattern) {
  const size_t size = hn::Lanes(d8);
  const Mixer<D8> mixer(d8, opacity);
  // The last vector overlaps the one before it, so it is mixed before any is stored.
  const size_t end = bytes - size;
  const auto last = mixer.mix(row + end, mixer.part(pattern + end % kPatternPeriod));
  const auto first_part = mixer.part(pattern), second_part = mixer.part(pattern + size),
             third_part = mixer.part(pattern + 2 * size);
  size_t at = 0;
  for (; at + 3 * size <= bytes; at += 3 * size) {
    mixer.store(mixer.mix(row + at, first_part), row + at);
    mixer.store(mixer.mix(row + at + size, second_part), row + at + size);
    mixer.store(mixer.mix(row + at + 2 * size, third_part), row + at + 2 * size);
  }
  if (at + size <= bytes) mixer.store(mixer.mix(row + at, first_part), row + at), at += size;
  if (at + size <= bytes) mixer.store(mixer.mix(row + at, second_part), row + at);
  mixer.store(last, row + end);
}
#endif

// Returns whether the row was mixed: not if it is shorter than every vector.
bool tint_vectors([[maybe_unused]] uint8_t* row, [[maybe_unused]] uint8_t opacity,
                  [[maybe_unused]] size_t bytes, [[maybe_unused]] const uint8_t* pattern) {
#if HWY_TARGET != HWY_SCALAR
  const hn::CappedTag<uint8_t, 64> wide;
  const hn::CappedTag<uint8_t, 16> narrow;
  if (bytes >= hn::Lanes(wide)) return tint_with(wide, row, opacity, bytes, pattern), true;
  if (bytes >= hn::Lanes(narrow)) return tint_with(narrow, row, opacity, bytes, pattern), true;
#endif
  return false;
}

}  // namespace weir::draw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::draw {

HWY_EXPORT(tint_vectors);

void tint_row(std::byte* row, uint8_t opacity, size_t bytes, const Pattern& pattern) noexcept {
  auto* const d = reinterpret_cast<uint8_t*>(row);
  if (HWY_DYNAMIC_DISPATCH(tint_vectors)(d, opacity, bytes, pattern.data())) return;
  for (size_t i = 0; i < bytes; ++i) d[i] = mixed(d[i], pattern[i % kPatternPeriod], opacity);
}

}  // namespace weir::draw
#endif
