// Measures what a tracer adds to a frame: CPU time of slices of a stream before and after the
// tracer starts, in one pipeline that keeps playing. Two processes differ by about 5 % through
// their memory layout, more than a tracer adds; within one process the layout stays the same.
//   tracing_cost TRACER FRAMES SLICES LINE
// TRACER: its name in GStreamer's registry; `none` shows the difference between the two halves of a
// process. FRAMES: per slice; SLICES: before, and as many after. LINE: an endless source and its
// downstream elements; a fakesink is added. Prints the medians of the slices in seconds per frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#define GST_USE_UNSTABLE_API
#include <gst/gst.h>
#include <gst/gsttracer.h>
#include <gst/gsttracerfactory.h>

#include <condition_variable>
#include <cstdlib>
#include <mutex>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"
#include "one_core.hpp"
#include "rounds.hpp"

namespace {

using weir::gst::Ref;

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "tracing_cost: %s\n", what.c_str());
  std::exit(1);
}

// Like GST_TRACERS, but in the middle of a stream. Never freed, because hooks cannot be removed.
void make_tracer(const std::string& name) {
  if (name == "none") return;
  const auto feature =
      Ref<GstPluginFeature>::adopt(gst_registry_lookup_feature(gst_registry_get(), name.c_str()));
  const auto loaded =
      Ref<GstPluginFeature>::adopt(feature ? gst_plugin_feature_load(feature.get()) : nullptr);
  if (!loaded || !GST_IS_TRACER_FACTORY(loaded.get())) fail("no tracer " + name);
  const GType type = gst_tracer_factory_get_tracer_type(GST_TRACER_FACTORY_CAST(loaded.get()));
  const char* parameters = name == "weir" ? "file=" : "";
  if (!g_object_new(type, "params", parameters, nullptr)) fail(name + " cannot be made");
}

// Called for each frame on the only streaming thread.
class Slices {
 public:
  Slices(std::string tracer, int frames, size_t slices)
      : tracer_(std::move(tracer)), frames_(frames), slices_(slices) {}

  void frame() {
    if (++count_ % frames_ != 0 || halves_[1].size() == slices_) return;
    const double now = weir::bench::seconds(CLOCK_PROCESS_CPUTIME_ID);
    if (to_warm_up_ > 0)
      --to_warm_up_;
    else
      halves_[half_].push_back((now - began_) / frames_);
    if (halves_[half_].size() == slices_) end_half();
    began_ = weir::bench::seconds(
        CLOCK_PROCESS_CPUTIME_ID);  // excludes the end of a half from the slices
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return done_; });
  }
  double median(size_t half) const { return weir::bench::median(halves_[half]); }

 private:
  static constexpr int kWarmUp = 5;

  void end_half() {
    if (half_ == 0) {
      make_tracer(tracer_);
      half_ = 1;
      to_warm_up_ = kWarmUp;
      return;
    }
    std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

  std::string tracer_;
  int frames_;
  size_t slices_;
  int64_t count_ = 0;
  double began_ = 0;
  int to_warm_up_ = kWarmUp;
  size_t half_ = 0;
  std::vector<double> halves_[2];
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
};

void on_frame(GstElement*, GstBuffer*, GstPad*, Slices* slices) {
  slices->frame();
}

GstBusSyncReply on_message(GstBus*, GstMessage* message, gpointer) {
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS) fail("the stream ended");
  if (GST_MESSAGE_TYPE(message) != GST_MESSAGE_ERROR) {
    gst_message_unref(message);
    return GST_BUS_DROP;
  }
  GError* error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  fail(error->message);
}

}  // namespace

int main(int argc, char** argv) {
  weir::bench::stay_on_one_core();
  gst_init(&argc, &argv);
  if (argc != 5) fail("TRACER FRAMES SLICES LINE");
  const int frames = std::atoi(argv[2]), count = std::atoi(argv[3]);
  if (frames < 1 || count < 1) fail("FRAMES and SLICES are numbers from 1 on");
  Slices slices(argv[1], frames, static_cast<size_t>(count));
  const std::string line =
      std::string(argv[4]) + " ! fakesink name=out async=false signal-handoffs=true";
  const auto pipeline = weir::bench::launched(line);
  const auto out = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  g_signal_connect(out.get(), "handoff", G_CALLBACK(on_frame), &slices);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  gst_bus_set_sync_handler(bus.get(), on_message, nullptr, nullptr);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  slices.wait();
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  std::printf("{\"without\": %.12f, \"with\": %.12f}\n", slices.median(0), slices.median(1));
}
