// Draws the graph of a run as SVG.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "report.hpp"

namespace weir::app {

// `shown`: indices into summary["elements"].
std::string graph_picture(const Json& summary, const std::vector<size_t>& shown);

}  // namespace weir::app
