// Checks what a runner allocates for frames by counting every allocation of this program. Excluded
// from sanitizer builds, which replace the same operators.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "core/preprocess/plan_reference_test_support.hpp"
#include "core/preprocess/runner.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

std::atomic<size_t> allocations = 0;

void* allocated(void* memory) {
  ++allocations;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// The array versions call these.
void* operator new(size_t size) {
  return allocated(std::malloc(size > 0 ? size : 1));
}
void* operator new(size_t size, std::align_val_t alignment) {
  const auto line = static_cast<size_t>(alignment);
  return allocated(std::aligned_alloc(line, (size + line - 1) / line * line));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace weir::preprocess {
namespace {

using testing::Pixels;

// Regions in different places, each with its own columns.
TEST(Runner, AllocatesForTheFirstFramesOnly) {
  constexpr uint32_t kRegions = 20, kPlaces = 3;
  for (const char* format : {"RGB", "NV12", "I420", "YUY2"})
    for (const bool cosited : {false, true}) {
      Pixels pixels(format, 1024, 256, 1);
      pixels.picture.cosited_columns = cosited;
      Preparation p;
      p.source = pixels.picture;
      p.width = 64;
      p.height = 16;
      p.resize = Resize::Area;
      std::vector<PreprocessPlan> plans;
      std::vector<std::vector<std::byte>> out(kRegions);
      std::vector<Job> jobs;
      for (uint32_t i = 0; i < kRegions; ++i) {
        p.crop = Rect{16 * i, 0, 512, 256};
        plans.push_back(*PreprocessPlan::make(p));
        out[i].resize(*p.tensor().bytes());
      }
      for (uint32_t i = 0; i < kRegions; ++i) jobs.push_back({&plans[i], out[i]});
      Runner runner(2);
      const auto run = [&](uint32_t frame) {
        for (uint32_t i = 0; i < kRegions; ++i)
          if (!plans[i].set_crop({16 * (i + frame % kPlaces), 0, 512, 256})) return false;
        return bool{runner.run(pixels.planes, jobs)};
      };
      for (uint32_t frame = 0; frame < 2 * kPlaces; ++frame) ASSERT_TRUE(run(frame));
      const size_t before = allocations;
      bool all = true;
      for (uint32_t frame = 0; frame < 4 * kPlaces; ++frame) all = run(frame) && all;
      EXPECT_EQ(allocations - before, 0u) << format << (cosited ? ", co-sited" : "");
      EXPECT_TRUE(all);
    }
}

}  // namespace
}  // namespace weir::preprocess

#endif
