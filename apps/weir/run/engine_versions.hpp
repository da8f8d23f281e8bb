// The versions of the engines that a pipeline runs models with.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "report.hpp"

namespace weir::app {

// {"onnxruntime": "1.20.1"}: each engine of a tensor_filter in the pipeline, which has opened its
// models, with the version of the engine's library. Without engines that have no version, and
// without those of isolate=process, which this process does not load.
Json engine_versions(GstElement* pipeline);

}  // namespace weir::app
