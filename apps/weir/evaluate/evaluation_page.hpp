// The page of `weir evaluate --page`: one self-contained HTML file with the worst pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "evaluate/comparison.hpp"

namespace weir::app {

// Decodes the pictures of the worst examples again. One that cannot be shown is left out.
std::string evaluation_page(const Comparison& comparison);

}  // namespace weir::app
