// The facts of a run, as JSON: what `weir run --report FILE.json` writes, and what the page shows.
// docs/tracing.md lists the members.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "report.hpp"

namespace weir::app {

// `outcome`: the output of --json; `trace`: the summary of the tracer; `text`: the description of
// the pipeline, which has played and is not yet in state NULL.
Json report_document(const Json& outcome, Json trace, const std::string& text,
                     GstElement* pipeline);

}  // namespace weir::app
