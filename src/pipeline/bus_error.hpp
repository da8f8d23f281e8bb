// What elements report, as Weir's errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "weir/result.hpp"

namespace weir::pipeline {

// Of an error message: Weir's own with all its parts, others by their domain. The element's name is
// in `what`.
Error error_of(GstMessage* message);
// Of gst_parse_launch.
Error parse_error(const GError& error, const char* text);

}  // namespace weir::pipeline
