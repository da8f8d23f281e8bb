// Converts GStreamer's errors to Weir's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "weir/result.hpp"

namespace weir::pipeline {

// From a warning or an error: Weir's own errors keep all parts, others are mapped by domain. `what`
// contains the element's name.
Error to_error(GstMessage* message);
// From gst_parse_launch().
Error parse_error(const GError& error, const char* text);

}  // namespace weir::pipeline
