// launch_elements: the elements that a gst-launch-1.0 description creates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace weir {

struct LaunchElements {
  struct Property {
    std::string factory, name, value;  // value without quotes and backslashes
  };
  std::vector<std::string> factories;     // in the order of the text
  std::vector<std::string> outside_bins;  // those of them that no parentheses enclose
  std::vector<std::string> uri_schemes;   // "file" of file:///x, which creates a source or a sink
  std::vector<Property> properties;       // properties of the factories
};

// For a check before anything is created, so it is conservative: the result contains every factory
// that GStreamer would use, even if GStreamer rejects the description. For a description that
// GStreamer accepts, it contains no other names.
LaunchElements launch_elements(std::string_view description);

}  // namespace weir
