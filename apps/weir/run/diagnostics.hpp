// Diagnostic: a warning or an error of a pipeline, and how it is printed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct Diagnostic {
  Error error;
  bool has_code = false;          // false: GStreamer's, where `error.code` is not used
  std::string element{}, path{};  // "detect", "pipeline0/bin0/detect"; "" before elements exist
  std::string debug{};            // GStreamer's debug text
  bool is_closed_window = false;  // the user closed the window of a video sink
};

// Precondition: a warning or an error. Errors about files as of gst::read_posted_error().
Diagnostic parse_diagnostic(GstMessage* message);

// "WEIR-2001"; "" without a code.
std::string get_id(const Diagnostic& diagnostic);

// All print to standard error.
void print_warning(const Diagnostic& warning);
// Errors that only follow from one of Weir's are left out, and so are repeated ones.
void print_errors(const std::vector<Diagnostic>& errors);

}  // namespace weir::app
