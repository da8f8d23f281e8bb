// PipelineRun: plays a pipeline until it ends.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "run/diagnostics.hpp"
#include "run/muxed_files.hpp"
#include "run/played_pipeline.hpp"
#include "run/sink_counter.hpp"
#include "run/source_watch.hpp"

namespace weir::app {

// TimeLimit: the time of stop_after() was over.
enum class RunEnd { Eos, Error, Interrupted, TimeLimit };

class PipelineRun;
// What play() reports, on its thread. Each may be empty.
struct RunEvents {
  std::function<void(const PipelineRun&)> progress;  // periodically
  std::function<void(const std::string&)> notice;    // a line to show at once
  std::function<void(const Diagnostic&)> warning;    // of an element, when it posts it
  std::function<void()> playing;                     // each time the pipeline has come to PLAYING
  std::function<void()> stopping;                    // once, before frames in flight are waited for
};

class PipelineRun {
 public:
  explicit PipelineRun(PlayedPipeline played);
  ~PipelineRun();
  PipelineRun(const PipelineRun&) = delete;
  PipelineRun& operator=(const PipelineRun&) = delete;

  // Blocks until the end. The first SIGINT or SIGTERM sends EOS, the second stops. Files of muxers
  // get up to five seconds to become complete after an error and after such a stop.
  RunEnd play(RunEvents events);

  // These come before play().
  // For a pipeline that sends no EOS when it is asked for: the first signal stops.
  void stop_at_first_signal() noexcept { stops_at_first_signal_ = true; }
  // Sends EOS after this time; stops if the stream then takes more than five seconds to end. It is
  // an error if the pipeline does not play by then.
  void stop_after(double seconds) noexcept { time_limit_ = seconds; }
  // Each property that changes becomes a notice: "videotestsrc0.src: caps = ...".
  void show_properties() noexcept { shows_properties_ = true; }

  GstElement* pipeline() const noexcept { return played_.element.get(); }
  const SinkCounter& sinks() const noexcept { return *sinks_; }
  const SourceWatch& sources() const noexcept { return *sources_; }
  double seconds() const;           // from the first frame to the end, or until now; 0 before
  double seconds_to_start() const;  // from play() to the first frame at a sink; 0 if none came
  double frame_rate() const;        // frames after the first per second, of the busiest sink
  // How much of the stream has been played, 0 to 1; nullopt where its length is not known.
  std::optional<double> played() const;
  const std::vector<Diagnostic>& errors() const noexcept { return errors_; }
  const std::vector<Diagnostic>& warnings() const noexcept { return warnings_; }

 private:
  void on_message(GstMessage* message);
  void on_error(GstMessage* message);
  void on_eos();
  void on_signal();
  void on_time_limit();
  void on_end_limit();
  bool is_playing() const;
  void stop();  // reports that the stream is about to end
  void send_eos();
  void complete_files();
  std::vector<std::string> wait_for_files(double seconds);
  void drain_bus();
  void finish(RunEnd end);

  PlayedPipeline played_;
  std::unique_ptr<SinkCounter> sinks_;
  std::unique_ptr<SourceWatch> sources_;
  std::optional<MuxedFiles> files_;  // once they are completed
  gst::Unique<GMainLoop, g_main_loop_unref> loop_;
  std::vector<Diagnostic> errors_, warnings_;
  RunEvents events_;
  gint64 started_ = 0, ended_ = 0;  // monotonic microseconds
  int signals_ = 0;
  guint end_timer_ = 0;    // of on_end_limit(); 0 = none
  double time_limit_ = 0;  // seconds; 0 = none
  bool is_time_over_ = false, shows_properties_ = false, stops_at_first_signal_ = false;
  bool is_eos_sent_ = false, is_eos_ = false;
  std::optional<RunEnd> end_;  // the first reason
};

}  // namespace weir::app
