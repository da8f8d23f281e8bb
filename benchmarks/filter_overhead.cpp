// Compares appsrc ! tensor_filter ! fakesink with ONNX Runtime in a plain loop: same model and
// settings, preallocated memory, one core, interleaved blocks of frames in one process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>

#include "filter_stage.hpp"
#include "one_core.hpp"
#include "rounds.hpp"

// Usage: filter_overhead LIBRARY MODEL NAME FRAMES ROUNDS AT_MOST_US
int main(int argc, char** argv) {
  weir::bench::stay_on_one_core();
  gst_init(&argc, &argv);
  if (argc != 7) return 2;
  constexpr int kThreads = 1;
  const int frames = std::atoi(argv[4]), rounds = std::atoi(argv[5]);
  weir::bench::BareLoop bare(argv[1], argv[2], kThreads);
  weir::bench::Pipeline pipeline(bare, argv[2], kThreads);
  weir::bench::Pipeline stock(bare, "identity");
  const auto costs = weir::bench::medians(
      {[&] { bare.run(frames); }, [&] { pipeline.run(frames); }, [&] { stock.run(frames); }},
      rounds);
  const std::string name = std::string("tensor_filter, ") + argv[3];
  const double max = std::atof(argv[6]);
  const auto us = [&](double seconds) {
    return std::to_string(static_cast<int>(seconds / frames * 1e6)) + " us";
  };
  const std::string floor =
      "bare loop, " + us(costs[0].wall) + "; with identity in its place " + us(costs[2].wall);
  weir::bench::report(name + ": wall above it", floor,
                      (costs[1].wall - costs[0].wall) / frames * 1e6, "us", max);
  weir::bench::report(name + ": CPU of all threads above it", floor,
                      (costs[1].cpu - costs[0].cpu) / frames * 1e6, "us", max);
}
