// The sticky event "weir-zones", with which tensor_zones sends its zones downstream, for elements
// that draw them: docs/zones.md defines it.
//
//   weir-zones, version=(uint)1, source=(string)zones, zones=(string)"{ \"version\": 1, ... }"
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct ZonesOfSource {
  std::string source;  // as in weir-source
  std::string zones;   // the text of the zones file
  bool operator==(const ZonesOfSource&) const = default;
};

Ref<GstEvent> make_zones_event(const ZonesOfSource& zones);

// nullopt for another event, another version, or contents that are not as described above. The text
// may be invalid.
std::optional<ZonesOfSource> parse_zones_event(GstEvent* event);

}  // namespace weir::gst
