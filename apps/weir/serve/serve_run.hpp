// ServeRun: plays one pipeline for each model until a signal ends them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "report.hpp"
#include "run/diagnostics.hpp"
#include "run/played_pipeline.hpp"
#include "serve/served_models.hpp"

namespace weir::app {

struct ServedPipeline {
  NamedModel model;
  PlayedPipeline played;
};

class ServeRun {
 public:
  // Precondition: stopped pipelines.
  explicit ServeRun(std::vector<ServedPipeline> pipelines);
  ~ServeRun();
  ServeRun(const ServeRun&) = delete;
  ServeRun& operator=(const ServeRun&) = delete;

  // Starts all pipelines and handles signals from then on. Returns the errors; empty = all play.
  std::vector<Diagnostic> start();
  // Blocks until a signal. The first SIGINT or SIGTERM ends the streams after the requests that
  // they have; the second one, or nine seconds, ends them at once. A model whose pipeline fails is
  // started again after a second, and if it fails soon again after twice as long as before, up to
  // half a minute. The exit status.
  int play();
  // Stops all pipelines. False: a model still runs ten seconds after the first signal, or a second
  // after the second one, and the process should end without it, because nothing can interrupt an
  // invoke.
  bool stop();

  // "input float32 3:224:224:1", as the filter reports them after start().
  Json describe_tensors(size_t pipeline) const;
  // Returns the statistics of all pipelines, as ledgers() does.
  Json statistics() const;
  // The port that a source listens on.
  unsigned port() const;
  size_t size() const noexcept { return served_.size(); }
  const NamedModel& model(size_t pipeline) const { return served_[pipeline]->what.model; }

 private:
  struct Served : std::enable_shared_from_this<Served> {
    Served(ServeRun* runs, ServedPipeline pipeline) : run(runs), what(std::move(pipeline)) {}

    ServeRun* run;
    ServedPipeline what;
    guint watch = 0, restart = 0;
    guint wait_ms = 0;       // before the last restart
    gint64 played_from = 0;  // by g_get_monotonic_time()
    bool ended = false;
    bool is_stopping = false;  // to start again
  };
  void on_message(Served* served, GstMessage* message);
  void restart(Served* served);
  void on_stopped(Served* served);
  void start_later(Served* served);
  void start_again(Served* served);
  void end_if_all_ended(int status);
  void on_signal();
  void end(int status);

  std::vector<std::shared_ptr<Served>> served_;
  gst::Unique<GMainLoop, g_main_loop_unref> loop_;
  std::vector<guint> signal_sources_;
  int signals_ = 0, status_ = 0;
  std::chrono::steady_clock::time_point stop_by_;
  unsigned port_ = 0;  // of all sources, once the first one listens
};

}  // namespace weir::app
