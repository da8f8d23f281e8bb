// SourceEvents: calls a program when an appsrc needs data, has enough, or seeks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "capi-nnstreamer/nnstreamer.h"
#include "core/infer/queue/call_gate.hpp"

namespace weir::application {

// Thread-safe.
class SourceEvents : public std::enable_shared_from_this<SourceEvents> {
 public:
  // `pipeline`: see InCallback.
  SourceEvents(std::string source, const void* pipeline)
      : source_(std::move(source)), pipeline_(pipeline) {}
  SourceEvents(const SourceEvents&) = delete;
  SourceEvents& operator=(const SourceEvents&) = delete;

  const std::string& source() const noexcept { return source_; }
  // Replaces the functions; `handle` is passed to them.
  void set(const ml_pipeline_src_callbacks_s& functions, ml_pipeline_src_h handle, void* data);
  // Follows this appsrc instead of the one before; null: none.
  void connect(GstElement* element);
  // Waits for a function that runs on another thread. None is called afterwards. Call it before the
  // last reference goes.
  void close();

 private:
  struct Functions {
    ml_pipeline_src_callbacks_s functions{};
    ml_pipeline_src_h handle = nullptr;
    void* data = nullptr;
  };
  Functions functions() const;
  // Runs `body` with the functions unless this is closed.
  template <class Body>
  void call(Body&& body);
  // `data` is a shared_ptr to the SourceEvents: a function may release its handle.
  static void on_need_data(GstElement* element, guint length, gpointer data);
  static void on_enough_data(GstElement* element, gpointer data);
  static gboolean on_seek_data(GstElement* element, guint64 offset, gpointer data);

  const std::string source_;
  const void* const pipeline_;
  infer::CallGate gate_;
  mutable std::mutex mutex_;  // guards the rest
  Functions functions_;
  GstElement* element_ = nullptr;
  std::vector<gulong> handlers_;
};

}  // namespace weir::application
