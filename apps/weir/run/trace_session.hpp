// TraceSession: the tracer of Weir's plug-in, active in this process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "gstcpp/element/ref.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {

class TraceSession {
 public:
  // Uses the tracer that GST_TRACERS started, or starts one that writes no file. It traces elements
  // created afterwards. FILE_NOT_FOUND when the plug-in is not found.
  static Result<TraceSession> start();
  // The summary of the trace so far; see core/trace/summary.hpp.
  Json summary() const;

 private:
  explicit TraceSession(gst::Ref<GstObject> tracer) : tracer_(std::move(tracer)) {}
  gst::Ref<GstObject> tracer_;
};

}  // namespace weir::app
