// Kernels for CPUs with more than Highway's AVX3: VBMI picks bytes from two vectors, and VNNI adds
// products of bytes. Highway 1.0 has a target for both, but compiles it with instructions
// (AVX-VNNI) that some of these CPUs lack. Callers are compiled for the target AVX3 and check
// has_avx512_bytes().
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace weir::transform {

#if defined(__x86_64__)
#define WEIR_AVX512_BYTES 1
#else
#define WEIR_AVX512_BYTES 0
#endif

// False if the CPU lacks one of them or a test has disabled them.
bool has_avx512_bytes() noexcept;
void allow_avx512_bytes(bool allowed) noexcept;

struct ByteSums {
  uint64_t sum = 0, squares = 0;
};
// Adds count / 64 * 64 bytes, each XORed with `turned` (0 or 0x80) first.
ByteSums add_bytes_avx512(const uint8_t* in, size_t count, uint8_t turned) noexcept;

// Transposes sixteen rows by four columns of three-byte pixels. Strides are in bytes. Reads 16
// bytes for each 12 of a row; writes exactly the 48 bytes of each column.
inline constexpr size_t kTripleRows = 16, kTripleColumns = 4;
void move_triples_avx512(const uint8_t* in, size_t in_stride, uint8_t* out, size_t out_stride,
                         size_t tiles) noexcept;

}  // namespace weir::transform
