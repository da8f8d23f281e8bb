// The page of `weir run --report`: one HTML file that needs nothing else.
#pragma once
#include <string>

#include "report.hpp"

namespace weir::app {

// `outcome`: what --json prints; `summary`: what the tracer sums up; `pipeline`: its description.
std::string report_page(const Json& outcome, const Json& summary, const std::string& pipeline);

}  // namespace weir::app
