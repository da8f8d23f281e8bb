// Pipeline: a program's pipeline, and leases that delay its destruction.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "callback_holds.hpp"
#include "element_restriction.hpp"
#include "handles.hpp"
#include "ml_error.hpp"
#include "sink_callbacks.hpp"
#include "source_events.hpp"
#include "weir/pipeline.h"

namespace weir::application {

struct UnrefElement {
  void operator()(GstElement* element) const noexcept { gst_object_unref(element); }
};
using ElementRef = std::unique_ptr<GstElement, UnrefElement>;

// Thread-safe.
class Pipeline : public Object, public std::enable_shared_from_this<Pipeline> {
 public:
  static constexpr const char* kKind = "pipeline";
  struct StateCallback {
    ml_pipeline_state_cb function = nullptr;
    void* data = nullptr;
  };
  // Pauses the new pipeline. ML_ERROR_STREAMS_PIPE for a text or a state change that fails,
  // ML_ERROR_NOT_SUPPORTED for an element that the configuration does not allow,
  // ML_ERROR_PERMISSION_DENIED when the configuration cannot be read.
  static std::variant<std::shared_ptr<Pipeline>, Refusal> construct(const char* text,
                                                                    StateCallback callback);
  ~Pipeline() override;
  const char* kind() const noexcept override { return kKind; }

  // A lease: keeps the pipeline open. OPTION_VALUE: it was destroyed.
  class Use {
   public:
    Use(Use&& other) noexcept : pipeline_(std::move(other.pipeline_)) {}
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() {
      if (pipeline_) pipeline_->leave();
    }
    weir_pipeline* get() const noexcept { return pipeline_->pipeline_; }
    Pipeline& operator*() const noexcept { return *pipeline_; }
    Pipeline* operator->() const noexcept { return pipeline_.get(); }

   private:
    friend class Pipeline;
    explicit Use(std::shared_ptr<Pipeline> pipeline) : pipeline_(std::move(pipeline)) {}
    std::shared_ptr<Pipeline> pipeline_;
  };
  Result<Use> use();
  // Returns CANCELLED if this thread is in a callback of this pipeline.
  Status not_from_its_callback() const;
  // Stops the pipeline. CANCELLED: this is a streaming thread of the pipeline.
  Status stop();
  // Discards frames and errors and pauses the pipeline.
  Status flush();
  // The state of GStreamer's pipeline, or its failure.
  GstStateChangeReturn get_state(GstClockTime limit, GstState* state) const;
  // Converts an error of a call: ML_ERROR_STREAMS_PIPE if the stream has failed.
  Refusal refused(const Error& error) const;
  // Stops the pipeline, waits for all leases and frees it. Must not be called in its callbacks.
  void close();

  // Returns the callbacks of the tensor_sink or appsink with this name; null if there is none.
  SinkCallbacks* sink(const std::string& name) const;
  // Returns the factory name, for example "valve"; "" if the text contains no such element.
  std::string get_kind(const std::string& name) const;
  // Returns a handle, which is destroyed with the pipeline if it is not removed earlier.
  void* add_part(std::shared_ptr<Object> part);
  void remove_part(void* handle);
  // Ends the stream of the appsrc; tells whether that has happened since the last flush.
  int end(const std::string& name, weir_error** error);
  bool has_ended(const std::string& name) const;
  // Calls `events` for the appsrc of its name, as long as `events` exists.
  void connect_events(const std::shared_ptr<SourceEvents>& events);

 private:
  Pipeline() = default;
  void leave();
  Status connect();
  Status connect_sink(const std::string& name);
  bool flush_by_events();
  Status restart();
  void hold(const std::string& name, const std::string& kind);
  Status prepare();
  static void on_state(int state, void* self);

  // Written only by construct().
  weir_pipeline* pipeline_ = nullptr;
  StateCallback state_callback_;
  std::map<std::string, std::string> kinds_;
  std::map<std::string, std::unique_ptr<SinkCallbacks>> sinks_;
  std::vector<CallbackName> held_;

  mutable std::mutex mutex_;  // guards the rest
  std::set<std::string> ended_;
  std::set<void*> parts_;  // handles
  std::vector<std::weak_ptr<SourceEvents>> events_;
  std::condition_variable left_;
  size_t uses_ = 0;
  bool closed_ = false;
};

// Leases the pipeline of a handle.
Result<Pipeline::Use> use_pipeline(void* handle);

// Checks an element. OPTION_VALUE: no element of this name, or its kind is not in `kinds`, a list
// separated by " or " (empty: any).
Status check_kind(const Pipeline::Use& pipeline, const char* name, const std::string& kinds);

}  // namespace weir::application
