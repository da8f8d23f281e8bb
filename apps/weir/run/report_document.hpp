// The report of a run: `weir run --report FILE.json` writes its facts, whose members
// docs/tracing.md lists, and `--report FILE.html` one self-contained page that shows them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "report.hpp"

namespace weir::app {

// `outcome`: the output of --json; `trace`: the summary of the tracer; `text`: the description of
// the pipeline, which has played and is not yet in state NULL.
Json report_document(const Json& outcome, Json trace, const std::string& text,
                     GstElement* pipeline);

// `document`: of report_document().
std::string report_page(const Json& document);

// Draws the graph of a run as SVG, in lines that fit the width of a page. `trace`: of
// report_document(); `shown`: indices into trace["elements"]; `marked`: the name of the element
// that the verdict is about.
std::string graph_picture(const Json& trace, const std::vector<size_t>& shown,
                          const std::string& marked);

}  // namespace weir::app
