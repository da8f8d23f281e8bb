// PipelineRun: plays a pipeline until it ends and counts the frames at its sinks.
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

#include "gstcpp/element/ref.hpp"

namespace weir::app {

// The parts of a bus message; messages of Weir's elements have all of them.
struct Complaint {
  std::string element;  // element name, "" before elements exist
  std::string id;       // "WEIR-2001", "" for other messages
  std::string what, offered, needed, difference, fix;
  std::string debug;              // GStreamer's debug text
  bool is_closed_window = false;  // the user closed the window of a video sink
  bool operator==(const Complaint&) const = default;
};

// Precondition: a warning or an error.
Complaint complaint_of(GstMessage* message);

enum class RunEnd { Eos, Error, Interrupted };

struct SinkCount {
  std::string name;
  std::atomic<gint64>* first;  // shared by the run: time of the first frame at any sink
  std::atomic<uint64_t> frames = 0;
};

class PipelineRun {
 public:
  // Precondition: a GstPipeline in state NULL.
  explicit PipelineRun(gst::Ref<GstElement> read);
  ~PipelineRun();
  PipelineRun(const PipelineRun&) = delete;
  PipelineRun& operator=(const PipelineRun&) = delete;

  // Blocks until the end. The first SIGINT or SIGTERM sends EOS, the second stops. `progress` is
  // called periodically from this thread; `say` with messages to show at once.
  RunEnd play(const std::function<void(const PipelineRun&)>& progress,
              const std::function<void(const std::string&)>& say);

  // For a pipeline that sends no EOS when it is asked for: the first signal stops.
  void stop_at_first_signal() noexcept { stops_at_first_signal_ = true; }

  GstElement* pipeline() const noexcept { return pipeline_.get(); }
  uint64_t frames() const;    // sum over all sinks
  double seconds() const;     // from the first frame to the end, or until now; 0 before
  double frame_rate() const;  // frames after the first per second, of the busiest sink
  std::vector<std::pair<std::string, uint64_t>> sinks() const;
  const std::vector<Complaint>& errors() const noexcept { return errors_; }
  const std::vector<Complaint>& warnings() const noexcept { return warnings_; }

 private:
  void count_at(GstElement* element);
  void on_message(GstMessage* message);
  void on_signal();
  void drain_bus();
  void finish(RunEnd end);
  static GstPadProbeReturn on_data(GstPad*, GstPadProbeInfo* info, gpointer sink);

  gst::Ref<GstElement> pipeline_;
  gst::Unique<GMainLoop, g_main_loop_unref> loop_;
  mutable std::mutex mutex_;                       // guards sinks_
  std::vector<std::unique_ptr<SinkCount>> sinks_;  // exist as long as probes may run
  std::vector<Complaint> errors_, warnings_;
  std::function<void(const PipelineRun&)> progress_;
  std::function<void(const std::string&)> say_;
  std::atomic<gint64> first_ = 0;  // monotonic microseconds of the first frame; 0 = none yet
  gint64 ended_ = 0;
  int signals_ = 0;
  bool stops_at_first_signal_ = false;
  RunEnd end_ = RunEnd::Eos;
};

}  // namespace weir::app
