// Parses a pipeline's description; errors show the place.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::app {

// Returns a GstPipeline in state NULL, even for a single element. `words` is the description as one
// argument or split by a shell. OPTION_SYNTAX when it cannot be parsed.
Result<gst::Ref<GstElement>> read_pipeline(const std::vector<std::string>& words);

}  // namespace weir::app
