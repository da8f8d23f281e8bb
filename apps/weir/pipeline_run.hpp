// PipelineRun: plays a pipeline to its end and counts what reaches its sinks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gstcpp/ref.hpp"

namespace weir::app {

// A message of the bus in parts; those of Weir's elements carry all of them.
struct Complaint {
  std::string element;  // the element's name, "" when it came before there were any
  std::string id;       // "WEIR-2001", "" when it is not one of Weir's
  std::string what, offered, needed, difference, fix;
  std::string debug;  // GStreamer's own words for it
  bool operator==(const Complaint&) const = default;
};

enum class Ending { Eos, Error, Interrupted };

struct SinkCount {
  std::string name;
  std::atomic<gint64>* first;  // of the run: when a frame first came to any sink
  std::atomic<uint64_t> frames = 0;
};

class PipelineRun {
 public:
  // Takes a GstPipeline in state NULL.
  explicit PipelineRun(gst::Ref<GstElement> read);
  ~PipelineRun();
  PipelineRun(const PipelineRun&) = delete;
  PipelineRun& operator=(const PipelineRun&) = delete;

  // Blocks until the end. SIGINT and SIGTERM send EOS the first time and stop the second time.
  // `progress` is called now and then from this thread; `say` with what is to be told at once.
  Ending play(const std::function<void(const PipelineRun&)>& progress,
              const std::function<void(const std::string&)>& say);

  GstElement* pipeline() const noexcept { return pipeline_.get(); }
  uint64_t frames() const;    // of all sinks together
  double seconds() const;     // from the first frame to the end, or to now; 0 before
  double frame_rate() const;  // frames after the first per second, of the busiest sink
  std::vector<std::pair<std::string, uint64_t>> sinks() const;
  const std::vector<Complaint>& errors() const noexcept { return errors_; }
  const std::vector<Complaint>& warnings() const noexcept { return warnings_; }

 private:
  void count_at(GstElement* element);
  void on_message(GstMessage* message);
  void on_signal();
  void drain_bus();
  void finish(Ending ending);
  static GstPadProbeReturn on_data(GstPad*, GstPadProbeInfo* info, gpointer sink);

  gst::Ref<GstElement> pipeline_;
  gst::Unique<GMainLoop, g_main_loop_unref> loop_;
  mutable std::mutex mutex_;                       // guards sinks_
  std::vector<std::unique_ptr<SinkCount>> sinks_;  // as long as probes may run
  std::vector<Complaint> errors_, warnings_;
  std::function<void(const PipelineRun&)> progress_;
  std::function<void(const std::string&)> say_;
  std::atomic<gint64> first_ = 0;  // monotonic microseconds of the first frame, 0 = not yet
  gint64 ended_ = 0;
  int signals_ = 0;
  Ending ending_ = Ending::Eos;
};

}  // namespace weir::app
