// soak SECONDS: edits pipelines at random for so long, and tells what became of memory and frames.
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
// More than this in the second half of a run is taken for a leak. The first half warms pools and
// the arenas of the heap.
constexpr double kMostKilobytesPerMinute = 512;

struct Sample {
  double seconds, kilobytes;
};

double resident_kilobytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1024;
}

// Least squares over the later half: kilobytes a minute.
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

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const char* model = std::getenv("WEIR_TEST_MODEL");
  if (argc != 2 || !model) {
    std::fprintf(stderr, "usage: WEIR_TEST_MODEL=FILE soak SECONDS (tools/soak sets the rest)\n");
    return 2;
  }
  const double most = std::atof(argv[1]);
  const auto start = std::chrono::steady_clock::now();
  const auto now = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::vector<Sample> memory;
  uint64_t frames = 0, edits = 0, lost = 0, faults = 0;
  double told = -10;
  std::printf("%8s %10s %12s %8s %12s\n", "seconds", "edits", "frames", "lost", "RSS KB");
  for (uint32_t seed = 1; now() < most; ++seed) {
    weir::soak::EditedPipeline pipeline(seed, model, weir::soak::MuxEdits::Yes);
    std::string wrong;
    for (int i = 0; i < kEdits && wrong.empty(); ++i) wrong = pipeline.edit();
    wrong += pipeline.finish();
    if (!wrong.empty()) {
      std::fprintf(stderr, "%s\n", wrong.c_str());
      ++faults;
    }
    frames += pipeline.frames(), edits += pipeline.edits(), lost += pipeline.lost();
    memory.push_back({now(), resident_kilobytes()});
    if (now() - told < 10 && now() < most) continue;
    told = now();
    std::printf("%8.0f %10lu %12lu %8lu %12.0f\n", told, edits, frames, lost,
                memory.back().kilobytes);
    std::fflush(stdout);
  }
  const double growth = slope(memory);
  // A short run has nothing but warming up in it.
  const bool grows = most >= 300 && growth > kMostKilobytesPerMinute;
  std::printf("memory: %+.1f KB a minute in the second half (at most %.0f, from 5 minutes on)\n",
              growth, kMostKilobytesPerMinute);
  std::printf("frames lost: %lu of %lu; pipelines with faults: %lu of %zu\n", lost, frames, faults,
              memory.size());
  return lost > 0 || faults > 0 || grows ? 1 : 0;
}
