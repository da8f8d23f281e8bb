// Prints warnings and errors of pipelines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "run/pipeline_run.hpp"

namespace weir::app {

// To standard error, warnings first. Errors that only follow from one of Weir's are left out, and
// so are repeated ones.
void print_complaints(const std::vector<Complaint>& warnings, const std::vector<Complaint>& errors);
void print_complaints(const PipelineRun& run);

}  // namespace weir::app
