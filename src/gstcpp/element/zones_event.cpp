// Writes and reads the event "weir-zones".
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/zones_event.hpp"

namespace weir::gst {
namespace {

constexpr char kZonesName[] = "weir-zones";
constexpr guint kZonesVersion = 1;

}  // namespace

Ref<GstEvent> make_zones_event(const ZonesOfSource& zones) {
  return Ref<GstEvent>::adopt(
      gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY,
                           gst_structure_new(kZonesName, "version", G_TYPE_UINT, kZonesVersion,
                                             "source", G_TYPE_STRING, zones.source.c_str(), "zones",
                                             G_TYPE_STRING, zones.zones.c_str(), nullptr)));
}

std::optional<ZonesOfSource> parse_zones_event(GstEvent* event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_CUSTOM_DOWNSTREAM_STICKY) return std::nullopt;
  const GstStructure* structure = gst_event_get_structure(event);
  if (!gst_structure_has_name(structure, kZonesName)) return std::nullopt;
  guint version = 0;
  const char* source = gst_structure_get_string(structure, "source");
  const char* zones = gst_structure_get_string(structure, "zones");
  if (!gst_structure_get_uint(structure, "version", &version) || version != kZonesVersion ||
      !source || !zones)
    return std::nullopt;
  return ZonesOfSource{source, zones};
}

}  // namespace weir::gst
