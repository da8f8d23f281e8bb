// The sticky events with the names of classes and the zones of a stream of results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// The sticky event "weir-labels/SOURCE", with which tensor_decoder names the classes of its results
// downstream: docs/results.md defines it.
//
//   weir-labels/yolox_nano, version=(uint)1, source=(string)yolox_nano,
//     labels=<(string)person, (string)bicycle>
// Each source has an event of its own, so that the events of several streams that are joined stay
// beside each other.

struct LabelsOfSource {
  std::string source;               // as in weir-source
  std::vector<std::string> labels;  // of class 0 and those after it
  bool operator==(const LabelsOfSource&) const = default;
};

Ref<GstEvent> make_labels_event(const LabelsOfSource& labels);

// nullopt for another event, another version, or contents that are not as described above. Any
// element may have made the event: the numbers and lengths of labels are bounded.
std::optional<LabelsOfSource> parse_labels_event(GstEvent* event);

// The sticky event "weir-zones", with which tensor_zones sends its zones downstream, for elements
// that draw them: docs/zones.md defines it.
//
//   weir-zones, version=(uint)1, source=(string)zones, zones=(string)"{ \"version\": 1, ... }"

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
