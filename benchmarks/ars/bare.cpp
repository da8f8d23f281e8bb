// The engines alone: invokes the networks of a variant as often as the pipeline would for a number
// of frames, in a loop with nothing around it, and prints the seconds and the CPU seconds.
//
//   ars-bare a|b|c FRAMES MODULES NETWORKS
//
// Each invoke is of one thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <charconv>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string_view>

#include "weir/model.hpp"

namespace {

struct Network {
  std::string path;
  weir::ModelOptions options;
  int64_t invokes;
};

// How many windows of `length` frames, each `step` after the one before, `frames` have.
int64_t windows(int64_t frames, int64_t length, int64_t step) {
  return frames < length ? 0 : (frames - length) / step + 1;
}

Network filter(const std::string& modules, const std::string& networks, const char* name,
               const char* weights, int64_t invokes) {
  return {modules + "/libars-" + name + ".so",
          {.engine = "custom", .options = {{"weights", networks + "/" + weights}}},
          invokes};
}

std::vector<Network> make_networks(std::string_view variant, int64_t frames,
                                   const std::string& modules, const std::string& networks) {
  if (variant == "c")
    return {{networks + "/radio_network.onnx",
             {.engine = "onnxruntime", .threads = 1},
             windows(frames, 75, 25)}};
  const int64_t results = windows(frames, 8, 4);
  std::vector<Network> found{
      filter(modules, networks, "event-network", "event_network.f32", results)};
  if (variant == "b")
    found.push_back(filter(modules, networks, "sequence-network", "sequence_network.f16",
                           windows(results, 12, 3)));
  return found;
}

struct Taken {
  double seconds = 0, cpu_seconds = 0;
};

// Returns the time of the invokes. The numbers vary from element to element, as a stream's do.
weir::Result<Taken> run(const Network& network) {
  auto model = weir::Model::open(network.path, network.options);
  if (!model) return model.error();
  const auto info = model->inputs().at(0);
  std::vector<float> values(static_cast<size_t>(info.elements()));
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i * 7919 % 13) / 13;
  const weir::TensorView input(values.data(), values.size() * sizeof(float), info.type);
  if (const auto warm = model->invoke({input}); !warm) return warm.error();
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  for (int64_t i = 0; i < network.invokes; ++i)
    if (const auto out = model->invoke({input}); !out) return out.error();
  return Taken{std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
               static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC};
}

}  // namespace

int main(int argc, char** argv) {
  int64_t frames = 0;
  if (argc == 5) std::from_chars(argv[2], argv[2] + std::string_view(argv[2]).size(), frames);
  const std::string_view variant = argc == 5 ? argv[1] : "";
  if (frames < 1 || (variant != "a" && variant != "b" && variant != "c"))
    return std::fprintf(stderr, "ars-bare a|b|c FRAMES MODULES NETWORKS\n"), 2;
  Taken all;
  for (const auto& network : make_networks(variant, frames, argv[3], argv[4])) {
    const auto taken = run(network);
    if (!taken) return std::fprintf(stderr, "%s\n", taken.error().message().c_str()), 1;
    all.seconds += taken->seconds;
    all.cpu_seconds += taken->cpu_seconds;
  }
  std::printf("%.6f %.6f\n", all.seconds, all.cpu_seconds);
  return 0;
}
