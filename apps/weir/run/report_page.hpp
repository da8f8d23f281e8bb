// Makes the page of `weir run --report`: one self-contained HTML file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "report.hpp"

namespace weir::app {

// `document`: of report_document().
std::string report_page(const Json& document);

}  // namespace weir::app
