// Measures a worker process per frame: the same engine and frames in this process and in a worker,
// as wall-clock time of the streaming thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <string>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

constexpr int kFrames = 300;
constexpr size_t kElements = 224 * 224 * 3, kFew = 1024;

std::string caps(const char* type, size_t elements = kElements) {
  return std::string("other/tensors,format=static,num_tensors=1,dimensions=(string)") +
         std::to_string(elements) + ",types=(string)" + type + ",framerate=(fraction)30/1";
}

}  // namespace

// Usage: isolation_cost MODEL ROUNDS
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 3) return 2;
  const std::string filter = std::string("tensor_filter framework=unruly model=") + argv[1];
  const std::string isolated = filter + " isolate=process";
  // The transform writes directly to the memory that the downstream element proposes.
  const std::string before = "tensor_transform mode=typecast option=uint8 ! ";
  const auto clear = [](GstBuffer* buffer) { gst_buffer_memset(buffer, 0, 0, 2); };
  using weir::bench::ElementStage;
  ElementStage written_here(before + filter, caps("uint16").c_str(), 2 * kElements);
  ElementStage written_there(before + isolated, caps("uint16").c_str(), 2 * kElements);
  ElementStage here(filter, caps("uint8").c_str(), kElements);
  ElementStage copied_there(isolated, caps("uint8").c_str(), kElements);
  ElementStage few_here(before + filter, caps("uint16", kFew).c_str(), 2 * kFew);
  ElementStage few_there(before + isolated, caps("uint16", kFew).c_str(), 2 * kFew);
  const auto frames = [&clear](ElementStage& stage) {
    return [&stage, &clear] { stage.push(kFrames, clear); };
  };
  const int rounds = std::atoi(argv[2]);
  const auto costs = weir::bench::min({frames(written_here), frames(written_there), frames(here),
                                       frames(copied_there), frames(few_here), frames(few_there)},
                                      rounds);
  const auto above = [&](size_t with, size_t without) {
    return (costs[with].wall - costs[without].wall) / kFrames * 1e6;
  };
  const char* const floor = "the same engine in this process";
  weir::bench::report("isolate=process, 1 KB written by a transform: wall above it", floor,
                      above(5, 4), "us", 40);
  weir::bench::report("isolate=process, 150 KB written by a transform: wall above it", floor,
                      above(1, 0), "us", 40);
  weir::bench::report("isolate=process, 150 KB that must be copied: wall above it", floor,
                      above(3, 2), "us", 60);
}
