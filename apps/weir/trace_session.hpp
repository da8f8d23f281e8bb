// TraceSession: the tracer of Weir's plug-in, at work in this process.
#pragma once
#include <gst/gst.h>

#include "gstcpp/ref.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {

class TraceSession {
 public:
  // Takes the tracer that GST_TRACERS started, or starts one that writes no file. Elements that are
  // made from now on are traced. FILE_NOT_FOUND when the plug-in is not found.
  static Result<TraceSession> start();
  // What was traced so far, as core/trace/summary.hpp says.
  Json summary() const;

 private:
  explicit TraceSession(gst::Ref<GstObject> tracer) : tracer_(std::move(tracer)) {}
  gst::Ref<GstObject> tracer_;
};

}  // namespace weir::app
