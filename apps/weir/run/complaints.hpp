// Prints the warnings and errors of a run.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "run/pipeline_run.hpp"

namespace weir::app {

// To standard error, warnings first. Errors that only follow from one of Weir's are left out, and
// so are repeated ones.
void print_complaints(const PipelineRun& run);

}  // namespace weir::app
