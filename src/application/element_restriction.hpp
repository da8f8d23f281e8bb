// ElementRestriction: the elements that pipelines of the application API may contain
// (docs/compatibility/app-api.md 8.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::application {

// Requires GStreamer.
class ElementRestriction {
 public:
  // Reads [element-restriction] of nnstreamer.ini and NNSTREAMER_element-restriction_KEY again. An
  // error when a configuration file exists and cannot be read or parsed, because it may restrict
  // elements.
  static Result<ElementRestriction> read();

  // Elements of Weir and NNStreamer are always allowed.
  bool allows(const std::string& factory) const;
  // OPTION_VALUE: it does not allow this factory.
  Status check(const std::string& factory) const;
  // Checks the names of elements in the text of a pipeline, before any is made. Names in
  // parentheses are those of a bin's children, which are not checked. Some elements have no name
  // there: bins, the capsfilters of caps, sources and sinks of a URI.
  Status check_text(const char* text) const;
  // Checks the elements that lie directly in the pipeline.
  Status check_children(GstElement* pipeline) const;

 private:
  bool enabled_ = false;
  std::vector<std::string> allowed_;
  std::string origin_;  // "/etc/nnstreamer.ini:7"
};

}  // namespace weir::application
