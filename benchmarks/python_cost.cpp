// Measures a Python filter per 150 KB frame: a script that returns its input against a C engine
// that copies it, in this process and in a worker. Also measures how two processes speed up a
// computing script despite Python's lock. Minimum of interleaved rounds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kFrames = 300, kBusyFrames = 40;
constexpr size_t kBytes = 224 * 224 * 3;

std::string caps(size_t elements, const char* type = "uint8") {
  return "other/tensors,format=static,num_tensors=1,dimensions=(string)" +
         std::to_string(elements) + ",types=(string)" + type + ",framerate=(fraction)30/1";
}

// About one millisecond of work in Python.
void write_busy_script(const std::string& path) {
  std::ofstream(path) << "class CustomFilter:\n"
                         "    def setInputDim(self, input_dims): return input_dims\n"
                         "    def invoke(self, input_array):\n"
                         "        sum(i * i for i in range(20000))\n"
                         "        return input_array\n";
}

// Waits for all results, because workers finish frames after push() has returned.
class CountedStage {
 public:
  explicit CountedStage(const std::string& filter) : stage_(filter, caps(64).c_str(), 64) {}
  void run() {
    stage_.push(kBusyFrames);
    total_ += kBusyFrames;
    while (stage_.stat("consumed") < total_)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
  }

 private:
  ElementStage stage_;
  uint64_t total_ = 0;
};

}  // namespace

// Usage: python_cost SCRIPT FOLDER ROUNDS; FOLDER receives a generated script
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 4) return 2;
  const int rounds = std::atoi(argv[3]);
  const std::string script = std::string("tensor_filter framework=python3 model=") + argv[1];
  const std::string c = "tensor_filter framework=identity";
  // The transform writes directly to the worker's shared memory, which the downstream element
  // proposes.
  const std::string before = "tensor_transform mode=typecast option=uint8 ! ";
  ElementStage bare(c, caps(kBytes).c_str(), kBytes);
  ElementStage here(script, caps(kBytes).c_str(), kBytes);
  ElementStage written(before + c, caps(kBytes, "uint16").c_str(), 2 * kBytes);
  ElementStage there(before + script + " isolate=process", caps(kBytes, "uint16").c_str(),
                     2 * kBytes);
  const auto costs =
      weir::bench::min({[&] { bare.push(kFrames); }, [&] { here.push(kFrames); },
                        [&] { written.push(kFrames); }, [&] { there.push(kFrames); }},
                       rounds);
  const auto report = [&](const char* name, size_t with, size_t without, double max) {
    weir::bench::report(name,
                        "an engine in C that copies it, " +
                            std::to_string(costs[without].wall / kFrames * 1e6).substr(0, 4) +
                            " us",
                        (costs[with].wall - costs[without].wall) / kFrames * 1e6, "us", max);
  };
  report("a filter in Python gives 150 KB on: wall above it", 1, 0, 5);
  report("isolate=process, 150 KB written by a transform: wall above it", 3, 2, 40);

  const std::string busy = std::string(argv[2]) + "/busy.py";
  write_busy_script(busy);
  const std::string filter = "tensor_filter framework=python3 model=" + busy;
  CountedStage one(filter), two(filter + " workers=2"),
      apart(filter + " isolate=process workers=2");
  const auto times =
      weir::bench::min({[&] { one.run(); }, [&] { two.run(); }, [&] { apart.run(); }}, rounds);
  weir::bench::report("a script that computes, isolate=process workers=2: time of a frame",
                      "workers=1; with workers=2 and one lock " +
                          std::to_string(times[1].wall / times[0].wall).substr(0, 4),
                      times[2].wall / times[0].wall, "x", 0.65);
}
