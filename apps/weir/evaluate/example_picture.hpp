// A picture with its truth and results, as HTML.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "evaluate/evaluator.hpp"

namespace weir::app {

// A figure: the picture as JPEG in the page, with boxes and points as SVG over it. "" if the
// picture cannot be read any more.
std::string example_picture(const Example& example);

}  // namespace weir::app
