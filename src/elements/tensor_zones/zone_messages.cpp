// Builds messages and warnings.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_zones/zone_messages.hpp"

#include <cmath>

#include "core/text/text.hpp"

namespace weir {
namespace {

void add_number(const char* name, float number, GstStructure* out) {
  if (std::isfinite(number)) gst_structure_set(out, name, G_TYPE_DOUBLE, double{number}, nullptr);
}

}  // namespace

void post_zone_event(GstElement* element, const zone::Event& event, const zone::Zone& zone,
                     const std::vector<std::string>* labels, GstClockTime running_time) {
  GstStructure* out =
      gst_structure_new("weir-zone-event", "event", G_TYPE_STRING, zone::name_of(event.kind),
                        "zone", G_TYPE_STRING, zone.name.c_str(), "track", G_TYPE_UINT, event.track,
                        "running-time", G_TYPE_UINT64, running_time, nullptr);
  if (event.class_index != zone::kNoClass) {
    const auto index = static_cast<size_t>(event.class_index);
    const std::string label =
        labels && index < labels->size() ? (*labels)[index] : std::to_string(index);
    gst_structure_set(out, "class", G_TYPE_INT, event.class_index, "label", G_TYPE_STRING,
                      label.c_str(), nullptr);
  }
  add_number("dwell", event.dwell, out);
  add_number("speed", event.speed.pixels, out);
  add_number("ground-speed", event.speed.metres, out);
  gst_element_post_message(element, gst_message_new_element(GST_OBJECT_CAST(element), out));
}

Error objects_without_track() {
  return Error{.code = Code::SPEC_MISMATCH,
               .what =
                   "no object has a track number: zones count the objects inside, but none that "
                   "enter, leave or cross",
               .offered = "30 frames with objects of track 0",
               .needed = "objects that are tracked from frame to frame",
               .fix = "tensor_tracker ! tensor_zones"};
}

Error frame_without_time() {
  return Error{.code = Code::TIME_INVALID,
               .what = "a frame has no timestamp: dwell times and speeds are not updated",
               .offered = "a buffer without a PTS",
               .needed = "a PTS in a segment of format time",
               .fix = "set do-timestamp=true at the source"};
}

Error time_goes_back(GstClockTime running_time) {
  return Error{.code = Code::TIME_INVALID,
               .what =
                   "the time of a frame is before that of the last frame: all tracks end and "
                   "start again",
               .offered = "running time " + time_text(running_time),
               .needed = "times that increase",
               .fix = "put a queue or a parser that orders the frames upstream"};
}

}  // namespace weir
