// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/value_json.hpp"

#include <nlohmann/json.hpp>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

using Json = nlohmann::ordered_json;

template <class Size, class At>
Json json_from_items(const GValue* value, Size size, At at) {
  Json out = Json::array();
  for (guint i = 0; i < size(value); ++i) out.push_back(json_from_value(at(value, i)));
  return out;
}

Json json_from_enum(const GValue* value) {
  const gst::Unique<GEnumClass, g_type_class_unref> values(
      static_cast<GEnumClass*>(g_type_class_ref(G_VALUE_TYPE(value))));
  const GEnumValue* found = g_enum_get_value(values.get(), g_value_get_enum(value));
  return found ? Json(found->value_nick) : Json(g_value_get_enum(value));
}

}  // namespace

Json json_from_value(const GValue* value) {
  if (GST_VALUE_HOLDS_STRUCTURE(value)) {
    const GstStructure* structure = gst_value_get_structure(value);
    return structure ? json_from_structure(structure) : Json(nullptr);
  }
  if (GST_VALUE_HOLDS_ARRAY(value))
    return json_from_items(value, gst_value_array_get_size, gst_value_array_get_value);
  if (GST_VALUE_HOLDS_LIST(value))
    return json_from_items(value, gst_value_list_get_size, gst_value_list_get_value);
  if (G_VALUE_HOLDS_STRING(value)) {
    const char* text = g_value_get_string(value);
    return text ? Json(text) : Json(nullptr);
  }
  if (G_VALUE_HOLDS_UINT64(value)) return g_value_get_uint64(value);
  if (G_VALUE_HOLDS_INT64(value)) return g_value_get_int64(value);
  if (G_VALUE_HOLDS_UINT(value)) return g_value_get_uint(value);
  if (G_VALUE_HOLDS_INT(value)) return g_value_get_int(value);
  if (G_VALUE_HOLDS_ULONG(value)) return g_value_get_ulong(value);
  if (G_VALUE_HOLDS_LONG(value)) return g_value_get_long(value);
  if (G_VALUE_HOLDS_DOUBLE(value)) return g_value_get_double(value);
  if (G_VALUE_HOLDS_FLOAT(value)) return g_value_get_float(value);
  if (G_VALUE_HOLDS_BOOLEAN(value)) return g_value_get_boolean(value) != FALSE;
  if (G_VALUE_HOLDS_ENUM(value)) return json_from_enum(value);
  const UniqueText text(gst_value_serialize(value));
  return text ? Json(text.get()) : Json(nullptr);
}

Json json_from_structure(const GstStructure* structure) {
  Json out = Json::object();
  for (int i = 0; i < gst_structure_n_fields(structure); ++i) {
    const char* name = gst_structure_nth_field_name(structure, static_cast<guint>(i));
    out[name] = json_from_value(gst_structure_get_value(structure, name));
  }
  return out;
}

}  // namespace weir::gst
