// Branch-free conversion between float16 and float32 for loops that compilers vectorise. A test
// checks that the bits equal those of weir::float16.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <bit>
#include <cstdint>

#include "core/tensor/float16.hpp"

namespace weir::transform {

inline float widen(float16 half) noexcept {
  const uint32_t sign = (uint32_t{half.bits} & 0x8000u) << 16;
  const uint32_t magnitude = uint32_t{half.bits} & 0x7FFFu;
  const float tiny = static_cast<float>(static_cast<int32_t>(magnitude)) * 0x1p-24f;  // subnormal
  const uint32_t normal = (magnitude << 13) + (112u << 23);
  const uint32_t special = (magnitude << 13) | 0x7F800000u;  // infinity, NaN
  uint32_t bits = magnitude < 0x400u ? std::bit_cast<uint32_t>(tiny) : normal;
  bits = magnitude >= 0x7C00u ? special : bits;
  return std::bit_cast<float>(bits | sign);
}

inline float16 round_to_half(float value) noexcept {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const uint32_t magnitude = bits & 0x7FFFFFFFu;
  // Adding 0.5 aligns the bits of a subnormal, and the FPU rounds to even.
  const float aligned = std::bit_cast<float>(magnitude < 0x38800000u ? magnitude : 0u) + 0.5f;
  const uint32_t tiny = std::bit_cast<uint32_t>(aligned) - 0x3F000000u;
  const uint32_t normal = (magnitude - 0x38000000u + 0xFFFu + ((magnitude >> 13) & 1u)) >> 13;
  const uint32_t nan = 0x7E00u | ((magnitude >> 13) & 0x1FFu);
  uint32_t half = magnitude < 0x38800000u ? tiny : normal;
  half = magnitude >= 0x477FF000u ? 0x7C00u : half;
  half = magnitude > 0x7F800000u ? nan : half;
  float16 out;
  out.bits = static_cast<uint16_t>(half | ((bits >> 16) & 0x8000u));
  return out;
}

}  // namespace weir::transform
