// Compares appsrc ! tensor_filter ! fakesink with the engine in a plain loop, as filter_overhead
// does for ONNX Runtime; also measures opening a model in a new process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <malloc.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>

#include "engine_floor.hpp"
#include "one_core.hpp"
#include "rounds.hpp"
#include "stream_stage.hpp"
#include "written_memory.hpp"

namespace {

using namespace weir::bench;

struct Input {
  std::vector<int64_t> shape;  // outermost-first
  size_t bytes = 1;
  bool uint8 = false;
  std::string caps;
};

// Parses "24:24:3:1", innermost first, and "uint8" or "float32".
Input make_input(const std::string& dimensions, const std::string& type) {
  Input out;
  out.uint8 = type == "uint8";
  std::istringstream parts(dimensions);
  for (std::string part; std::getline(parts, part, ':');)
    out.shape.insert(out.shape.begin(), std::atoll(part.c_str()));
  for (const int64_t extent : out.shape) out.bytes *= static_cast<size_t>(extent);
  if (!out.uint8) out.bytes *= sizeof(float);
  out.caps = "other/tensor,type=" + type + ",framerate=30/1,dimension=(string)" + dimensions;
  return out;
}

// Calls the engine in an `identity` on the streaming thread, without Weir: measures what the
// frames' path alone costs the engine.
class EngineInIdentity : public Stage {
 public:
  EngineInIdentity(EngineFloor* floor, const Input& input, int ahead)
      : Stage(input.caps, input.bytes, "identity name=engine signal-handoffs=true", ahead) {
    const auto identity =
        Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "engine"));
    g_signal_connect(identity.get(), "handoff", G_CALLBACK(invoke), floor);
  }

 private:
  static void invoke(GstElement*, GstBuffer*, EngineFloor* floor) { floor->run(1); }
};

}  // namespace

// Usage: engine_overhead ENGINE MODELS DIMENSIONS TYPE NAME FRAMES ROUNDS AT_MOST_US
// engine_overhead ENGINE MODELS DIMENSIONS TYPE bare|filter: milliseconds and KiB for one frame
// through a pipeline whose elements are loaded; with bare, an `identity` calls the engine
int main(int argc, char** argv) {
  if (argc != 6 && argc != 9) return 2;
  stay_on_one_core();
  gst_init(&argc, &argv);
  const Input input = make_input(argv[3], argv[4]);
  const std::string filter = std::string("tensor_filter framework=") + argv[1] +
                             " model=" + argv[2] + " input=" + argv[3] + " inputtype=" + argv[4] +
                             " custom=NumThreads:1";
  if (argc == 6) {
    // Excludes what a process does once for any engine: loading the plug-ins.
    Stage(input.caps, input.bytes, "identity").run(1);
    const auto loaded = Ref<GstElement>::adopt(gst_element_factory_make("tensor_filter", nullptr));
    malloc_trim(0);  // excludes freed memory that would be reused
    const double before = seconds(CLOCK_MONOTONIC);
    const long kib = written_kib();
    // Both stay open while their memory is counted.
    std::unique_ptr<EngineFloor> bare;
    std::unique_ptr<Stage> stage;
    if (std::strcmp(argv[5], "bare") == 0) {
      bare = make_floor(argv[2], input.shape, input.uint8);
      stage = std::make_unique<EngineInIdentity>(bare.get(), input, 1);
    } else {
      stage = std::make_unique<Stage>(input.caps, input.bytes, filter);
    }
    stage->run(1);
    const double ms = (seconds(CLOCK_MONOTONIC) - before) * 1e3;
    std::printf("{\"ms\": %.1f, \"kib\": %ld}\n", ms, written_kib() - kib);
    return 0;
  }
  const int frames = std::atoi(argv[6]), rounds = std::atoi(argv[7]);
  // Each has its own model, so that the previous one leaves the caches equally cold.
  const auto bare = make_floor(argv[2], input.shape, input.uint8);
  const auto called = make_floor(argv[2], input.shape, input.uint8);
  Stage stage(input.caps, input.bytes, filter, frames);
  EngineInIdentity identity(called.get(), input, frames);
  const auto costs =
      min({[&] { bare->run(frames); }, [&] { stage.run(frames); }, [&] { identity.run(frames); }},
          rounds);
  const auto us = [&](double above) { return above / frames * 1e6; };
  const std::string name = std::string("tensor_filter, ") + argv[5];
  const auto whole = [&](double seconds) { return std::to_string(static_cast<int>(us(seconds))); };
  const std::string floor = "the engine in a bare loop, " + whole(costs[0].wall) +
                            " us; called bare by an identity " + whole(costs[2].wall) + " us";
  report(name + ": wall above it", floor, us(costs[1].wall - costs[0].wall), "us",
         std::atof(argv[8]));
  report(name + ": CPU of all threads above it", floor, us(costs[1].cpu - costs[0].cpu), "us",
         std::atof(argv[8]));
}
