// Converts GStreamer's errors to Weir's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "weir/result.hpp"

namespace weir::pipeline {

struct BusError {
  Error error;            // `what` contains the element's name
  bool has_code = false;  // false: another element posted it, and the code is that of its domain
};

// From a warning or an error. Weir's own errors keep all parts.
BusError to_error(GstMessage* message);
// From gst_parse_launch().
Error parse_error(const GError& error, const char* text);

}  // namespace weir::pipeline
