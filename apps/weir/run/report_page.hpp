// Makes the page of `weir run --report`: one self-contained HTML file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "report.hpp"

namespace weir::app {

// `outcome`: the output of --json; `summary`: of the tracer; `pipeline`: its description.
std::string report_page(const Json& outcome, const Json& summary, const std::string& pipeline);

}  // namespace weir::app
