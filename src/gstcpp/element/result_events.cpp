// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/result_events.hpp"

#include <cstring>

namespace weir::gst {
namespace {

constexpr char kPrefix[] = "weir-labels/";
constexpr guint kLabelsVersion = 1;
constexpr size_t kMaxLabelLength = 4096;  // bytes, likewise of a source
constexpr guint kMaxLabels = 65536;

// Pads keep one sticky event of each name. Names of structures have letters, digits and "/-_.:".
std::string name_of_event(const std::string& source) {
  std::string out = kPrefix;
  for (const char c : source) {
    if (g_ascii_isalnum(c) || c == '-' || c == '_') {
      out += c;
      continue;
    }
    constexpr char kDigits[] = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    out += {'.', kDigits[byte / 16], kDigits[byte % 16]};
  }
  return out;
}

bool is_text(const char* text) {
  return text && strnlen(text, kMaxLabelLength + 1) <= kMaxLabelLength;
}

constexpr char kZonesName[] = "weir-zones";
constexpr guint kZonesVersion = 1;

}  // namespace

Ref<GstEvent> make_labels_event(const LabelsOfSource& labels) {
  GstStructure* out =
      gst_structure_new(name_of_event(labels.source).c_str(), "version", G_TYPE_UINT,
                        kLabelsVersion, "source", G_TYPE_STRING, labels.source.c_str(), nullptr);
  GValue list = G_VALUE_INIT;
  g_value_init(&list, GST_TYPE_ARRAY);
  for (const auto& label : labels.labels) {
    GValue item = G_VALUE_INIT;
    g_value_init(&item, G_TYPE_STRING);
    g_value_set_string(&item, label.c_str());
    gst_value_array_append_and_take_value(&list, &item);
  }
  gst_structure_take_value(out, "labels", &list);
  return Ref<GstEvent>::adopt(gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, out));
}

std::optional<LabelsOfSource> parse_labels_event(GstEvent* event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_CUSTOM_DOWNSTREAM_STICKY) return std::nullopt;
  const GstStructure* structure = gst_event_get_structure(event);
  if (!g_str_has_prefix(gst_structure_get_name(structure), kPrefix)) return std::nullopt;
  guint version = 0;
  const char* source = gst_structure_get_string(structure, "source");
  const GValue* list = gst_structure_get_value(structure, "labels");
  if (!gst_structure_get_uint(structure, "version", &version) || version != kLabelsVersion ||
      !is_text(source) || !list || !GST_VALUE_HOLDS_ARRAY(list) ||
      gst_value_array_get_size(list) > kMaxLabels)
    return std::nullopt;
  LabelsOfSource out{source, {}};
  for (guint i = 0; i < gst_value_array_get_size(list); ++i) {
    const GValue* item = gst_value_array_get_value(list, i);
    if (!G_VALUE_HOLDS_STRING(item) || !is_text(g_value_get_string(item))) return std::nullopt;
    out.labels.emplace_back(g_value_get_string(item));
  }
  return out;
}

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
