// Draws the graph of a run as SVG, in lines that fit the width of a page.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "report.hpp"

namespace weir::app {

// `trace`: of report_document(); `shown`: indices into trace["elements"]; `marked`: the name of the
// element that the verdict is about.
std::string graph_picture(const Json& trace, const std::vector<size_t>& shown,
                          const std::string& marked);

}  // namespace weir::app
