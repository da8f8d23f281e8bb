// Compares four streams through one model in batches of four with four filters without batching,
// and with ONNX Runtime's own gain from batches of four. All on one core, so that four threads do
// not compute in parallel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <condition_variable>
#include <mutex>
#include <string>
#include <vector>

#include "bare_loop.hpp"
#include "gstcpp/element/ref.hpp"
#include "launched.hpp"
#include "one_core.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::BareLoop;
using weir::gst::Ref;
constexpr int kStreams = 4;

class Streams {
 public:
  Streams(const BareLoop& bare, const std::string& model, const std::string& properties) {
    std::string launch;
    for (int i = 0; i < kStreams; ++i)
      launch += "appsrc name=in" + std::to_string(i) +
                " format=time block=true max-buffers=64 caps=\"" + bare.caps() +
                "\" ! tensor_filter custom=NumThreads:1 model=" + model + " " + properties +
                " ! fakesink name=out" + std::to_string(i) + " async=false signal-handoffs=true  ";
    pipeline_ = weir::bench::launched(launch);
    for (int i = 0; i < kStreams; ++i) {
      in_.push_back(element("in" + std::to_string(i)));
      g_signal_connect(element("out" + std::to_string(i)).get(), "handoff", G_CALLBACK(on_frame),
                       this);
    }
    buffer_ = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, bare.input_bytes(), nullptr));
    gst_buffer_memset(buffer_.get(), 0, 0, bare.input_bytes());
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  ~Streams() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }

  void run(int frames) {  // frames per stream
    {
      std::lock_guard lock(mutex_);
      wanted_ = kStreams * frames;
    }
    for (int i = 0; i < frames; ++i)
      for (const auto& in : in_)
        gst_app_src_push_buffer(GST_APP_SRC(in.get()), gst_buffer_copy(buffer_.get()));
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return wanted_ == 0; });
  }

 private:
  Ref<GstElement> element(const std::string& name) const {
    return Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), name.c_str()));
  }
  static void on_frame(GstElement*, GstBuffer*, GstPad*, Streams* self) {
    std::lock_guard lock(self->mutex_);
    if (--self->wanted_ == 0) self->done_.notify_one();
  }
  Ref<GstElement> pipeline_;
  std::vector<Ref<GstElement>> in_;
  Ref<GstBuffer> buffer_;
  std::mutex mutex_;  // guards wanted_
  std::condition_variable done_;
  int wanted_ = 0;
};

}  // namespace

// Usage: batching_cost LIBRARY MODEL NAME FRAMES ROUNDS
int main(int argc, char** argv) {
  weir::bench::stay_on_one_core();
  gst_init(&argc, &argv);
  if (argc != 6) return 2;
  const int frames = std::atoi(argv[4]), rounds = std::atoi(argv[5]);
  BareLoop one(argv[1], argv[2], 1), four(argv[1], argv[2], 1, kStreams);
  Streams apart(one, argv[2], "");
  Streams together(one, argv[2],
                   "shared-tensor-filter-key=benchmark batch-size=4 batch-timeout=100000000");
  const auto costs =
      weir::bench::min({[&] { one.run(kStreams * frames); }, [&] { four.run(frames); },
                        [&] { apart.run(frames); }, [&] { together.run(frames); }},
                       rounds);
  const std::string name = "tensor_filter batch-size=4, " + std::string(argv[3]);
  const auto of_four = [&](size_t candidate) { return costs[candidate].cpu / frames; };
  char floor[80];
  std::snprintf(floor, sizeof floor, "a bare batch of 4, %.0f us: %.2f x less than 4 of 1",
                of_four(1) * 1e6, of_four(0) / of_four(1));
  weir::bench::report(name + ": CPU for 4 frames", floor, of_four(3) / of_four(1), "x", 1 / 0.9);
  std::snprintf(floor, sizeof floor, "4 filters that gather nothing, %.0f us", of_four(2) * 1e6);
  weir::bench::report(name + ": CPU for 4 frames", floor, of_four(3) / of_four(2), "x",
                      of_four(1) / of_four(0) / 0.9);
}
