// SinkCallbacks: the callbacks for the frames of one tensor_sink or appsink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "capi-nnstreamer/nnstreamer.h"
#include "core/infer/queue/call_gate.hpp"
#include "weir/pipeline.h"

namespace weir::application {

struct SinkCallback {
  ml_pipeline_sink_cb function = nullptr;
  void* data = nullptr;
  infer::CallGate gate;
};

// Thread-safe.
class SinkCallbacks {
 public:
  explicit SinkCallbacks(const void* pipeline) : pipeline_(pipeline) {}

  void add(std::shared_ptr<SinkCallback> callback);
  void remove(const std::shared_ptr<SinkCallback>& callback);
  // weir_frame_function; `self` is a SinkCallbacks.
  static int on_frame(const weir_pulled* frame, void* self, weir_error** error);

 private:
  std::vector<std::shared_ptr<SinkCallback>> all() const;
  void hand_over(const weir_pulled* frame);

  const void* const pipeline_;
  mutable std::mutex mutex_;  // guards callbacks_
  std::vector<std::shared_ptr<SinkCallback>> callbacks_;
};

// Stands for the pipeline of a callback that belongs to no single one: a filter or a condition.
inline constexpr char kSomePipeline = 0;
// Returns the pipeline whose callback runs on this thread; null: none.
const void* pipeline_of_callback() noexcept;
// Marks the scope of a callback.
class InCallback {
 public:
  explicit InCallback(const void* pipeline) noexcept;
  InCallback(const InCallback&) = delete;
  InCallback& operator=(const InCallback&) = delete;
  ~InCallback();

 private:
  const void* before_;
};

}  // namespace weir::application
