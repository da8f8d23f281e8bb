// Detects the SIMD targets that this CPU can run, in place of Highway's library.
//
// Highway's library is not linked because version 1.0.3 measures the clock while it is loaded. The
// functions have its names and are hidden, because a process may load that library as well.
// SPDX-License-Identifier: LGPL-2.1-or-later
#undef HWY_SHARED_DEFINE
#include "hwy/targets.h"

#include <cpuid.h>

#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

namespace hwy {
namespace {

struct Registers {
  unsigned a = 0, b = 0, c = 0, d = 0;
};
Registers cpuid(unsigned leaf, unsigned subleaf) {
  Registers r;
  if (__get_cpuid_count(leaf, subleaf, &r.a, &r.b, &r.c, &r.d) == 0) return {};
  return r;
}
bool has(unsigned reg, std::initializer_list<unsigned> bits) {
  for (const unsigned bit : bits)
    if ((reg >> bit & 1) == 0) return false;
  return true;
}
// The register sets that the operating system saves when it switches threads.
unsigned saved_registers() {
  unsigned low = 0, high = 0;
  asm volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
}

// Bits as in the manuals of Intel (volume 2A, CPUID) and AMD (volume 3, appendix E). A target is
// available if the CPU has every instruction set that its code may use.
int64_t detect() {
  const Registers basic = cpuid(1, 0), more = cpuid(7, 0), extended = cpuid(0x80000001u, 0);
  int64_t targets = HWY_STATIC_TARGET;  // the baseline of this build
  const bool ssse3 = has(basic.d, {25, 26}) && has(basic.c, {0, 9});
  if (ssse3) targets |= HWY_SSSE3;
  const bool sse4 = ssse3 && has(basic.c, {1, 19, 20, 25});  // pclmul, sse4.1, sse4.2, aes
  if (sse4) targets |= HWY_SSE4;
  constexpr unsigned kOsSaves = 27, kVectors = 0x06, kWideVectors = 0xE6;
  if (!sse4 || !has(basic.c, {kOsSaves})) return targets;
  const unsigned saved = saved_registers();
  const bool avx2 = (saved & kVectors) == kVectors &&
                    has(basic.c, {12, 28, 29}) &&  // fma, avx, f16c
                    has(more.b, {3, 5, 8}) &&      // bmi, avx2, bmi2
                    has(extended.c, {5});          // lzcnt
  if (avx2) targets |= HWY_AVX2;
  const bool avx3 = avx2 && (saved & kWideVectors) == kWideVectors &&
                    has(more.b, {16, 17, 28, 30, 31});  // avx512 f, dq, cd, bw, vl
  if (avx3) targets |= HWY_AVX3;
  // vbmi, vbmi2, vaes, vpclmulqdq, vnni, bitalg, vpopcntdq
  if (avx3 && has(more.c, {1, 6, 9, 10, 11, 12, 14})) targets |= HWY_AVX3_DL;
  return targets;
}

std::atomic<int64_t> for_test{0}, disabled{0};

}  // namespace

// clang needs it for unreachable cases in Highway's headers.
void Abort(const char* file, int line, const char* format, ...) {
  std::fprintf(stderr, "Highway, %s:%d: ", file, line);
  va_list arguments;
  va_start(arguments, format);
  std::vfprintf(stderr, format, arguments);
  va_end(arguments);
  std::abort();
}

ChosenTarget& GetChosenTarget() {
  static ChosenTarget chosen;
  return chosen;
}

int64_t SupportedTargets() {
  static const int64_t detected = detect();
  const int64_t wanted = for_test.load();
  const int64_t targets = (wanted != 0 ? wanted : detected) & ~disabled.load();
  return targets == 0 ? HWY_STATIC_TARGET : targets;
}

void SetSupportedTargetsForTest(int64_t targets) {
  for_test = targets;
  GetChosenTarget().DeInit();
}

void DisableTargets(int64_t targets) {
  disabled = targets;
  GetChosenTarget().DeInit();
}

}  // namespace hwy
