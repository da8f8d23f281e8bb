// Compares tensor_filter workers=2 with two plain loops of ONNX Runtime on two threads: same model,
// one engine thread each, interleaved blocks of frames in one process, minimum of the rounds
// because other load only adds time. Also measures the pipeline around a filter: CPU time of the
// same engine called by an `identity` in its place.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdlib>
#include <thread>

#include "filter_stage.hpp"
#include "rounds.hpp"

namespace {

constexpr int kWorkers = 2, kThreads = 1;
constexpr double kMax = 1 / 0.95;  // 95 % of the frame rate

// Calls the engine on the streaming thread without Weir.
class EngineInIdentity : public weir::bench::Stage {
 public:
  EngineInIdentity(weir::bench::BareLoop* loop, int ahead)
      : Stage(loop->caps(), loop->input_bytes(), "identity name=engine signal-handoffs=true",
              ahead) {
    const auto identity = weir::bench::Ref<GstElement>::adopt(
        gst_bin_get_by_name(GST_BIN(pipeline_.get()), "engine"));
    g_signal_connect(identity.get(), "handoff", G_CALLBACK(invoke), loop);
  }

 private:
  static void invoke(GstElement*, GstBuffer*, weir::bench::BareLoop* loop) { loop->run(1); }
};

}  // namespace

// Usage: worker_cost LIBRARY MODEL NAME FRAMES ROUNDS
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 6) return 2;
  const int frames = std::atoi(argv[4]), rounds = std::atoi(argv[5]);
  weir::bench::BareLoop one(argv[1], argv[2], kThreads), two(argv[1], argv[2], kThreads);
  // The loops have their frames in advance, so the pipelines get theirs too.
  const int ahead = kWorkers * frames;
  weir::bench::Pipeline pipeline(one, argv[2], kThreads, "workers=2", ahead);
  EngineInIdentity identity(&one, ahead);
  const auto costs = weir::bench::min(
      {[&] {
         std::thread other([&] { two.run(frames); });
         one.run(frames);
         other.join();
       },
       [&] { pipeline.run(kWorkers * frames); }, [&] { identity.run(kWorkers * frames); }},
      rounds);
  const auto of_a_frame = [&](double seconds) {
    return std::to_string(static_cast<int>(seconds / frames / kWorkers * 1e6)) + " us a frame";
  };
  const std::string name = std::string("tensor_filter workers=2, ") + argv[3];
  weir::bench::report(name + ": wall", "two bare loops at once, " + of_a_frame(costs[0].wall),
                      costs[1].wall / costs[0].wall, "x", kMax);
  weir::bench::report(name + ": CPU of all threads",
                      "the engine called bare by an identity, " + of_a_frame(costs[2].cpu) +
                          "; in a bare loop " + of_a_frame(costs[0].cpu),
                      costs[1].cpu / costs[2].cpu, "x", kMax);
}
