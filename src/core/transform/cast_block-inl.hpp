// cast_block: converts the type of kChainBlock elements. Included once per CPU target, inside
// Highway's foreach_target; the loops have constant lengths and no branches, so compilers vectorise
// them for each target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#if defined(WEIR_CAST_BLOCK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef WEIR_CAST_BLOCK_INL
#undef WEIR_CAST_BLOCK_INL
#else
#define WEIR_CAST_BLOCK_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {

// Precondition: the memories do not overlap and are aligned.
using CastBlock = void (*)(const std::byte* in, std::byte* out) noexcept;

template <class From, class To>
void cast_block(const std::byte* in, std::byte* out) noexcept {
  const From* HWY_RESTRICT from = reinterpret_cast<const From*>(in);
  To* HWY_RESTRICT to = reinterpret_cast<To*>(out);
  for (size_t i = 0; i < kChainBlock; ++i) {
    if constexpr (std::same_as<From, To>) {
      to[i] = from[i];
    } else if constexpr (std::same_as<From, float16>) {
      to[i] = convert<To>(widen(from[i]));
    } else if constexpr (std::same_as<To, float16>) {
      to[i] = round_to_half(convert<float>(from[i]));
    } else {
      to[i] = convert<To>(from[i]);
    }
  }
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
