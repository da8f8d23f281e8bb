// The error for an element of a pipeline that is not installed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/result.hpp"

namespace weir::app {

// OPTION_SYNTAX. Says whether `name` belongs to one of Weir's plug-ins, is an element of NNStreamer
// that Weir lacks, or is near the name of an installed element. `text` is the pipeline.
Error missing_element(const std::string& name, const std::string& text);

}  // namespace weir::app
