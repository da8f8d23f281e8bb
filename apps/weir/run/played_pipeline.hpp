// PlayedPipeline: a pipeline of libweir-pipeline, with its messages for a main loop.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "gstcpp/element/ref.hpp"
#include "run/diagnostics.hpp"
#include "weir/pipeline.hpp"

namespace weir::app {

struct PlayedPipeline {
  // The frames of its sinks are discarded. OPTION_VALUE: not a GstPipeline in state NULL.
  static Result<PlayedPipeline> make(gst::Ref<GstElement> element);
  // Removes the errors that wait on the bus, and returns them.
  std::vector<Diagnostic> take_errors() const;

  gst::Ref<GstElement> element;
  gst::Ref<GstBus> bus;  // gets every message of the pipeline
  Pipeline pipeline;     // destroyed first: it stops
};

}  // namespace weir::app
