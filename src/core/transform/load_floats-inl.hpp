// load_floats: a vector of floats from as many elements of another type. Included once per CPU
// target, inside Highway's foreach_target.
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

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
