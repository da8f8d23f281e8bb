// soak SECONDS: edits pipelines at random for this time, and reports the use of memory and lost
// frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <vector>

#include "edited_pipeline.hpp"

namespace {

constexpr int kEdits = 60;
// A higher growth in the second half of a run counts as a leak. It is measured in allocated bytes,
// because resident memory also includes what the heap keeps between used blocks.
constexpr double kMaxKilobytesPerMinute = 64;

struct Sample {
  double seconds, kilobytes;
};

// Allocated bytes in all arenas, in kilobytes.
double live_kilobytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1024;
}

double resident_kilobytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1024;
}

// Least squares over the second half: kilobytes per minute.
double slope(const std::vector<Sample>& all) {
  const std::vector<Sample> half(all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2),
                                 all.end());
  const auto n = static_cast<double>(half.size());
  double t = 0, m = 0, tt = 0, tm = 0;
  for (const auto& s : half) {
    t += s.seconds, m += s.kilobytes;
    tt += s.seconds * s.seconds, tm += s.seconds * s.kilobytes;
  }
  const double spread = n * tt - t * t;
  return spread > 0 ? (n * tm - t * m) / spread * 60 : 0;
}

struct Totals {
  uint64_t frames = 0, edits = 0, lost = 0, faults = 0;
};

void edit_one(uint32_t seed, const char* model, Totals* totals) {
  weir::soak::EditedPipeline pipeline(seed, model);
  std::string wrong;
  for (int i = 0; i < kEdits && wrong.empty(); ++i) wrong = pipeline.edit();
  wrong += pipeline.finish();
  if (!wrong.empty()) {
    std::fprintf(stderr, "%s\n", wrong.c_str());
    ++totals->faults;
  }
  totals->frames += pipeline.frames();
  totals->edits += pipeline.edits();
  totals->lost += pipeline.lost();
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const char* model = std::getenv("WEIR_TEST_MODEL");
  if (argc != 2 || !model) {
    std::fprintf(stderr, "usage: WEIR_TEST_MODEL=FILE soak SECONDS (tools/soak sets the rest)\n");
    return 2;
  }
  const double max = std::atof(argv[1]);
  const auto start = std::chrono::steady_clock::now();
  const auto now = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::vector<Sample> memory;
  Totals totals;
  double reported = -10;
  std::printf("%8s %10s %12s %8s %12s %12s\n", "seconds", "edits", "frames", "lost", "live KB",
              "RSS KB");
  for (uint32_t seed = 1; now() < max; ++seed) {
    edit_one(seed, model, &totals);
    memory.push_back({now(), live_kilobytes()});
    if (now() - reported < 10 && now() < max) continue;
    reported = now();
    std::printf("%8.0f %10lu %12lu %8lu %12.0f %12.0f\n", reported, totals.edits, totals.frames,
                totals.lost, memory.back().kilobytes, resident_kilobytes());
    std::fflush(stdout);
  }
  const double growth = slope(memory);
  // A short run consists only of warming up.
  const bool grows = max >= 300 && growth > kMaxKilobytesPerMinute;
  std::printf(
      "memory: %+.1f KB a minute in the second half are not freed (at most %.0f, from 5 minutes "
      "on)\n",
      growth, kMaxKilobytesPerMinute);
  std::printf("frames lost: %lu of %lu; pipelines with faults: %lu of %zu\n", totals.lost,
              totals.frames, totals.faults, memory.size());
  return totals.lost > 0 || totals.faults > 0 || grows ? 1 : 0;
}
