// float16: IEEE 754 binary16 storage. Arithmetic happens in float.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

namespace weir {

struct float16 {
  uint16_t bits = 0;

  float16() = default;
  explicit float16(float value) noexcept;  // rounds to nearest, ties to even
  operator float() const noexcept;         // exact
};

static_assert(sizeof(float16) == 2);

}  // namespace weir
