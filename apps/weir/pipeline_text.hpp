// Reads a pipeline's description and, where it cannot be read, says at which place.
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::app {

// A GstPipeline in state NULL, also when the description is one element only. `words` is the
// description as one word, or as a shell cut it. OPTION_SYNTAX when it cannot be read.
Result<gst::Ref<GstElement>> read_pipeline(const std::vector<std::string>& words);

}  // namespace weir::app
