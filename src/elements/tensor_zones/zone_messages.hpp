// What tensor_zones posts on the bus: the message of an event, and warnings.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "core/zone/zone_counter.hpp"
#include "weir/result.hpp"

namespace weir {

// Posts the element message "weir-zone-event"; docs/zones.md lists its fields. `labels` names
// classes and may be null.
void post_zone_event(GstElement* element, const zone::Event& event, const zone::Zone& zone,
                     const std::vector<std::string>* labels, GstClockTime running_time);

Error objects_without_track();
Error frame_without_time();
Error time_goes_back(GstClockTime running_time);

}  // namespace weir
