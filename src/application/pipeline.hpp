// Pipeline: one of the program's, and the ways to use it that end with it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <variant>

#include "answer.hpp"
#include "element_restriction.hpp"
#include "handles.hpp"
#include "sink_callbacks.hpp"
#include "weir/pipeline.h"

namespace weir::application {

// Thread-safe.
class Pipeline : public Object, public std::enable_shared_from_this<Pipeline> {
 public:
  static constexpr const char* kKind = "pipeline";
  struct StateCallback {
    ml_pipeline_state_cb function = nullptr;
    void* data = nullptr;
  };
  // Errors of weir_pipeline_parse; ML_ERROR_PERMISSION_DENIED for an element that the configuration
  // does not allow, and where the configuration cannot be read.
  static std::variant<std::shared_ptr<Pipeline>, Refusal> construct(const char* text,
                                                                    StateCallback callback);
  ~Pipeline() override;
  const char* kind() const noexcept override { return kKind; }

  // What keeps the pipeline open as long as it lives. OPTION_VALUE: it was destroyed.
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
  // CANCELLED: this thread is in a callback of this pipeline.
  Status not_from_its_callback() const;
  // CANCELLED: this thread belongs to the stream.
  Status stop();
  // Stops it, waits for all uses, frees it. Not from its callbacks.
  void close();

  // Of the tensor_sink or appsink of this name; null where there is none.
  SinkCallbacks* sink(const std::string& name) const;
  // "valve"; "" where the text names no such element.
  std::string kind_of(const std::string& name) const;

 private:
  Pipeline() = default;
  void leave();
  // 1: not allowed.
  static int parse(const char* text, const std::optional<ElementRestriction>& restriction,
                   weir_pipeline** pipeline, weir_error** error);
  Status connect();
  static void on_state(int state, void* self);

  // Written by construct only.
  weir_pipeline* pipeline_ = nullptr;
  StateCallback state_callback_;
  std::map<std::string, std::string> kinds_;
  std::map<std::string, std::unique_ptr<SinkCallbacks>> sinks_;

  std::mutex mutex_;  // guards the rest
  std::condition_variable left_;
  size_t uses_ = 0;
  bool closed_ = false;
};

// The pipeline of a handle.
Result<Pipeline::Use> use_pipeline(void* handle);

}  // namespace weir::application
