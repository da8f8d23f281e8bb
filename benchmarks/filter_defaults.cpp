// Measures filters with their default threads and spinning: one pipeline, or several at once, each
// with its own streaming thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include "rounds.hpp"
#include "stream_stage.hpp"

namespace {

using namespace weir::bench;

// Parses "24:24:3:1", innermost first, and "uint8" or "float32".
size_t count_bytes(const std::string& dimensions, const std::string& type) {
  size_t bytes = type == "uint8" ? 1 : sizeof(float);
  for (size_t at = 0; at < dimensions.size(); at = dimensions.find(':', at) + 1) {
    bytes *= static_cast<size_t>(std::atoll(dimensions.c_str() + at));
    if (dimensions.find(':', at) == std::string::npos) break;
  }
  return bytes;
}

void run(const std::vector<std::unique_ptr<Stage>>& stages, int frames) {
  std::vector<std::thread> threads;
  for (const auto& stage : stages) threads.emplace_back([&] { stage->run(frames); });
  for (auto& thread : threads) thread.join();
}

}  // namespace

// Usage: filter_defaults DIMENSIONS TYPE FRAMES FILTERS PROPERTIES. Prints microseconds of wall and
// CPU time per frame of each of FILTERS pipelines `appsrc ! tensor_filter PROPERTIES ! fakesink`.
int main(int argc, char** argv) {
  if (argc != 6) return 2;
  gst_init(&argc, &argv);
  const std::string dimensions = argv[1], type = argv[2];
  const int frames = std::atoi(argv[3]), filters = std::atoi(argv[4]);
  const std::string caps =
      "other/tensor,type=" + type + ",framerate=30/1,dimension=(string)" + dimensions;
  std::vector<std::unique_ptr<Stage>> stages;
  for (int i = 0; i < filters; ++i)
    stages.push_back(std::make_unique<Stage>(caps, count_bytes(dimensions, type),
                                             std::string("tensor_filter ") + argv[5], frames));
  run(stages, frames / 4 + 1);  // warms up caches and lazily created threads
  const double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
  run(stages, frames);
  std::printf("{\"wall\": %.2f, \"cpu\": %.2f}\n", (seconds(CLOCK_MONOTONIC) - wall) / frames * 1e6,
              (seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu) / frames * 1e6);
}
