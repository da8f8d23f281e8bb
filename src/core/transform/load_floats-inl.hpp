// load_floats: loads elements of another type as a vector of floats; store_floats: stores it
// normally or non-temporally. Included once per CPU target, inside Highway's foreach_target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#if defined(WEIR_LOAD_FLOATS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef WEIR_LOAD_FLOATS_INL
#undef WEIR_LOAD_FLOATS_INL
#else
#define WEIR_LOAD_FLOATS_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {

// From: float32, int32, or an integer of 8 or 16 bits. Any alignment.
template <class FloatTag, class From>
HWY_INLINE hwy::HWY_NAMESPACE::Vec<FloatTag> load_floats(FloatTag df, const From* from) noexcept {
  namespace hn = hwy::HWY_NAMESPACE;
  if constexpr (std::is_same_v<From, float>) {
    return hn::LoadU(df, from);
  } else if constexpr (std::is_same_v<From, int32_t>) {
    return hn::ConvertTo(df, hn::LoadU(hn::Rebind<int32_t, FloatTag>(), from));
  } else {
    const hn::Rebind<int32_t, FloatTag> di;
    return hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(hn::Rebind<From, FloatTag>(), from)));
  }
}

// Whether non-temporal stores are faster for `count` floats made from other memory: large results
// leave the caches before they are read, and normal stores first read each line. Requires an
// aligned `out`.
template <class FloatTag>
HWY_INLINE bool worth_streaming(FloatTag df, const void* in, const float* out,
                                size_t count) noexcept {
  constexpr size_t kFloats = size_t{4} << 20;  // 16 MiB
  const size_t vector = hwy::HWY_NAMESPACE::Lanes(df) * sizeof(float);
  return count >= kFloats && in != out && reinterpret_cast<uintptr_t>(out) % vector == 0;
}

template <bool kStreamed, class FloatTag>
HWY_INLINE void store_floats(hwy::HWY_NAMESPACE::Vec<FloatTag> v, FloatTag df,
                             float* out) noexcept {
  namespace hn = hwy::HWY_NAMESPACE;
  if constexpr (kStreamed)
    hn::Stream(v, df, out);
  else
    hn::StoreU(v, df, out);
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
