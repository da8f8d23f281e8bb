// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/element_properties.hpp"

#include <string_view>

#include "gstcpp/element/elements.hpp"
#include "run/secrets.hpp"

namespace weir::app {
namespace {

bool is_shown(const GParamSpec* spec) {
  const GParamFlags needed = G_PARAM_READWRITE;
  return (spec->flags & needed) == needed && std::string_view(spec->name) != "name" &&
         std::string_view(spec->name) != "parent" &&
         !g_type_is_a(spec->value_type, G_TYPE_OBJECT) &&
         !g_type_is_a(spec->value_type, G_TYPE_POINTER);
}

std::string to_string(const GValue* value) {
  if (G_VALUE_HOLDS_STRING(value)) {
    const char* text = g_value_get_string(value);
    return text ? text : "";
  }
  const gst::UniqueText text(gst_value_serialize(value));
  return text ? text.get() : "";
}

Json read_properties(GstElement* element) {
  Json out = Json::object();
  guint count = 0;
  const gst::Unique<GParamSpec*, g_free> specs(
      g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count));
  for (guint i = 0; i < count; ++i) {
    GParamSpec* spec = specs.get()[i];
    if (!is_shown(spec)) continue;
    GValue value = G_VALUE_INIT;
    g_value_init(&value, spec->value_type);
    g_object_get_property(G_OBJECT(element), spec->name, &value);
    if (!g_param_value_defaults(spec, &value)) {
      const std::string text = to_string(&value);
      if (!text.empty()) out[spec->name] = is_secret(spec->name) ? "***" : text;
    }
    g_value_unset(&value);
  }
  return out;
}

}  // namespace

std::string_view get_class(GstElement* element) {
  const char* klass = gst_element_get_metadata(element, GST_ELEMENT_METADATA_KLASS);
  return klass ? klass : "";
}

std::string get_path(GstObject* object) {
  const gst::UniqueText name(gst_object_get_name(object));
  const auto parent = gst::Ref<GstObject>::adopt(gst_object_get_parent(object));
  return (parent ? get_path(parent.get()) + "/" : "") + (name ? name.get() : "");
}

Json changed_properties(GstElement* pipeline) {
  Json out = Json::object();
  for (const auto& element : gst::elements_in(pipeline))
    if (Json properties = read_properties(element.get()); !properties.empty())
      out[get_path(GST_OBJECT(element.get()))] = std::move(properties);
  return out;
}

}  // namespace weir::app
