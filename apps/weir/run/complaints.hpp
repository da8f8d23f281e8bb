// Prints warnings and errors of pipelines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "run/pipeline_run.hpp"

namespace weir::app {

// All print to standard error.
void print_warning(const Complaint& warning);
// Errors that only follow from one of Weir's are left out, and so are repeated ones.
void print_errors(const std::vector<Complaint>& errors);

}  // namespace weir::app
