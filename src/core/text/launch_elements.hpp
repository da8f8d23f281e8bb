// What the description of a pipeline, as gst-launch-1.0 takes it, may make elements of.
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
  std::vector<std::string> factories;    // in the text's order
  std::vector<std::string> uri_schemes;  // "file" of file:///x, which makes a source or a sink
  std::vector<Property> properties;      // of the factories
};

// For a check before anything is made, so it errs on the safe side: every factory that GStreamer
// would use is in the result, also in a description that GStreamer reports as wrong. A description
// that GStreamer accepts gives no other names.
LaunchElements launch_elements(std::string_view description);

}  // namespace weir
