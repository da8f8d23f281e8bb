// AllowedElements: restricts a pipeline to elements of listed factories.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::pipeline {

// Thread-safe. Each check fails with OPTION_VALUE and the first factory that is not allowed. "bin",
// "pipeline" and "capsfilter", which a description makes from parentheses and caps, are always
// allowed.
class AllowedElements {
 public:
  explicit AllowedElements(std::vector<std::string> factories) : factories_(std::move(factories)) {}

  // Call before GStreamer parses the description; creates no elements. Checks element names, URI
  // schemes, and the text of properties that take elements.
  Status check(std::string_view description) const;
  // Checks every element in the bin, recursively.
  Status check(GstBin* bin) const;
  Status check(GstElement* element) const;
  // Sets elements that are not allowed to NULL: what adds an element may start it after disable().
  void stop_others(GstBin* bin) const;

 private:
  Status check(std::string_view description, int depth) const;
  Status check_name(const std::string& factory) const;
  Status check_scheme(const std::string& scheme) const;

  std::vector<std::string> factories_;
};

// Stops the element, blocks data through it and keeps its bin from starting it.
void disable(GstElement* element);

}  // namespace weir::pipeline
