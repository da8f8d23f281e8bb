// AllowedElements: the only factories whose elements a pipeline may have.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::pipeline {

// Thread-safe. Each check is OPTION_VALUE with the first factory that is not allowed. "bin",
// "pipeline" and "capsfilter", which texts make of parentheses and caps, always are.
class AllowedElements {
 public:
  explicit AllowedElements(std::vector<std::string> factories) : factories_(std::move(factories)) {}

  // Before GStreamer reads the description: nothing is made. Names, schemes of URIs, and the texts
  // of properties that take elements.
  Status check(std::string_view description) const;
  // Every element in the bin, at any depth.
  Status check(GstBin* bin) const;
  Status check(GstElement* element) const;

 private:
  Status check(std::string_view description, int depth) const;
  Status check_name(const std::string& factory) const;
  Status check_scheme(const std::string& scheme) const;

  std::vector<std::string> factories_;
};

// Lets no data through the element and keeps its bin from starting it.
void disable(GstElement* element);

}  // namespace weir::pipeline
