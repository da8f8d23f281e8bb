// Builds the pipeline of `weir try`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "commands.hpp"
#include "launch/pipeline_description.hpp"
#include "try/try_model.hpp"
#include "weir/result.hpp"

namespace weir::app {

// The elements that turn pictures into a model's results: tensor_preprocess, tensor_filter,
// tensor_decoder.
PipelineDescription result_elements(const TryModel& model);

// Where results go as text: `fdsink fd=1` in a pipeline to paste.
// FILE_NOT_FOUND for an input that does not exist, OPTION_VALUE for an output of an unknown kind.
Result<PipelineDescription> try_pipeline(const TryOptions& options, const TryModel& model,
                                         const std::string& text_sink);

// Whether the input is a photo, by the extension of its name.
bool is_photo(const std::string& input);

// Opens the window of a pipeline that shows pictures. OPTION_VALUE if there is none: autovideosink
// itself only warns and shows nothing.
Status open_window(GstElement* pipeline);

}  // namespace weir::app
