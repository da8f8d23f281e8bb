// Pipeline: a GstPipeline made from text, with sources and sinks by name and errors as values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <thread>

#include "core/infer/queue/call_gate.hpp"
#include "pipeline/allowed_elements.hpp"
#include "pipeline/bus_error.hpp"
#include "pipeline/frame_sink.hpp"
#include "pipeline/frame_source.hpp"

namespace weir::pipeline {

// GRAPH_STALLS in a process that was forked from one in which pipelines ran: locks may be held for
// ever there.
Status check_process();
Status start_gstreamer();

enum class WaitResult { Done, TimePassed, Ended };  // weir_pipeline_result

// Thread-safe as documented in pipeline.h, which describes each function.
class Pipeline {
 public:
  static Result<std::unique_ptr<Pipeline>> parse(const char* text);
  static Result<std::unique_ptr<Pipeline>> adopt(GstElement* pipeline);
  // Destroys the pipeline: on this thread, or on a new one if this is a streaming thread, which
  // cannot wait for itself. No callback starts after it has returned.
  static void dispose(std::unique_ptr<Pipeline> pipeline) noexcept;
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  // Call once, while stopped. OPTION_VALUE: an element is not allowed; elements added later are
  // errors of the stream.
  Status restrict_to(AllowedElements allowed);

  Status start() { return change(GST_STATE_PLAYING); }
  Status pause() { return change(GST_STATE_PAUSED); }
  // CANCELLED in a callback of this pipeline; stop() also on any other streaming thread.
  Status stop();
  GstState state() const;
  // A negative limit means no limit.
  Result<WaitResult> wait(std::chrono::nanoseconds limit);

  // A warning or an error that an element posted.
  struct Message {
    bool is_error = false;
    Error error;
  };
  // Removes the oldest message and returns it; nullopt: none is left.
  std::optional<Message> read_message();

  Status push(const std::string& name, std::span<const weir_tensor> tensors, int64_t pts,
              int64_t duration);
  Status end(const std::string& name);
  // Those that the appsrc needs; none if it leaves a choice.
  Result<std::vector<TensorSpec>> source_tensors(const std::string& name) const;
  struct Pulled {
    WaitResult result = WaitResult::Done;
    std::shared_ptr<const PulledFrame> frame;
  };
  Result<Pulled> pull(const std::string& name, std::chrono::nanoseconds limit);
  Result<bool> ended(const std::string& name) const;
  Status on_frame(const std::string& name, FrameSink::Function function);
  Status discard(const std::string& name);
  // Call while stopped.
  Status on_state(std::function<void(GstState)> function);
  Status on_message(std::function<void(GstMessage*)> function);

  Result<gst::Ref<GstElement>> element(const std::string& name) const;
  // Sets a property of an element. The warning with which the element rejects a value is the error.
  Status set(const std::string& name, const std::string& property, const std::string& text);
  GstBin* bin() const noexcept { return GST_BIN(pipeline_.get()); }

 private:
  Pipeline(gst::Ref<GstElement> pipeline, bool is_adopted);
  // Refers from the bus to the pipeline. The bus keeps it alive while a message needs it.
  struct BusLink {
    infer::CallGate gate;
    Pipeline* pipeline;
  };
  static GstBusSyncReply on_posted(GstBus* bus, GstMessage* message, gpointer link);
  void handle(GstMessage* message);
  Status choose_while_stopped(const Error& refusal, const std::function<void()>& choose);
  void keep(bool is_error, BusError posted);
  void call_later(void (*function)(Pipeline&));
  void select_clock();
  void follow(GstState state);  // that an element asks for
  void took_state(GstMessage* message);
  void took_stream_status(GstMessage* message);
  bool is_own_thread() const;
  void halt();
  static void on_added(GstBin* bin, GstBin* parent, GstElement* element, Pipeline* self);
  std::optional<Error> failed() const;
  Status change(GstState state);
  Result<FrameSink*> sink(const std::string& name) const;
  Result<FrameSource*> source(const std::string& name) const;

  gst::Ref<GstElement> pipeline_;
  infer::CallGate callbacks_;  // the program's callbacks
  std::shared_ptr<BusLink> link_;
  std::optional<AllowedElements> allowed_;  // set by restrict_to(); nullopt: all
  gulong added_handler_ = 0;
  // Filled by the constructor; the maps do not change afterwards.
  // Elements of different bins may have one name.
  std::multimap<std::string, std::unique_ptr<FrameSink>, std::less<>> sinks_;
  std::multimap<std::string, std::unique_ptr<FrameSource>, std::less<>> sources_;
  std::mutex changes_;                           // held during state changes; taken before mutex_
  std::atomic<bool> stopped_ = true;             // written under changes_
  std::function<void(GstState)> on_state_;       // set while stopped
  std::function<void(GstMessage*)> on_message_;  // set while stopped
  // Last reported to on_state_; READY: stopped.
  std::atomic<GstState> reported_state_ = GST_STATE_READY;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  // The first since start with a code of Weir's, or the first: others follow from one with a code.
  std::optional<BusError> error_;
  std::deque<Message> messages_;  // not read; the newest
  bool ended_ = false;
  uint64_t stops_ = 0;                           // number of stop() calls
  std::set<std::thread::id> streaming_threads_;  // running threads
};

}  // namespace weir::pipeline
