// Finds out which property gst_parse_launch() could not set and which values it takes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/property_text.hpp"

#include <vector>

#include "core/text/choice.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

std::string value_not_accepted(GstElement* element, const GParamSpec* spec) {
  return kind_of(element) + " does not accept this value for " + spec->name;
}

std::vector<std::string> nicks_of(const GEnumClass* type) {
  std::vector<std::string> out;
  for (guint i = 0; i < type->n_values; ++i) out.emplace_back(type->values[i].value_nick);
  return out;
}
std::vector<std::string> nicks_of(const GFlagsClass* type) {
  std::vector<std::string> out;
  for (guint i = 0; i < type->n_values; ++i) out.emplace_back(type->values[i].value_nick);
  return out;
}

}  // namespace

std::string kind_of(GstElement* element) {
  GstElementFactory* factory = gst_element_get_factory(element);
  return factory ? gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory))
                 : G_OBJECT_TYPE_NAME(element);
}

Result<GParamSpec*> find_property(GstElement* element, const std::string& property) {
  auto* type = G_OBJECT_GET_CLASS(element);
  if (auto* spec = g_object_class_find_property(type, property.c_str())) return spec;
  std::vector<std::string> names;
  guint count = 0;
  const Unique<GParamSpec*, g_free> all(g_object_class_list_properties(type, &count));
  for (guint i = 0; i < count; ++i) names.emplace_back(all.get()[i]->name);
  return not_one_of(kind_of(element) + " has no such property", property, names);
}

Error refused_value(GstElement* element, GParamSpec* spec, const std::string& text) {
  Error out{.code = Code::OPTION_VALUE, .what = value_not_accepted(element, spec), .offered = text};
  if (G_IS_PARAM_SPEC_ENUM(spec)) {
    out = not_one_of(out.what, text, nicks_of(G_PARAM_SPEC_ENUM(spec)->enum_class));
  } else if (G_IS_PARAM_SPEC_FLAGS(spec)) {
    const auto nicks = nicks_of(G_PARAM_SPEC_FLAGS(spec)->flags_class);
    out = not_one_of(out.what, text, nicks);
    out.needed += "; join several with +";
  } else if (G_IS_PARAM_SPEC_BOOLEAN(spec)) {
    out.needed = "true or false";
  } else {
    out.needed = std::string("a ") + g_type_name(spec->value_type);
  }
  out.fix = "gst-inspect-1.0 " + kind_of(element);
  return out;
}

Status read_value(GstElement* element, GParamSpec* spec, const std::string& text, GValue* value) {
  if (spec->value_type == G_TYPE_STRING)
    g_value_set_string(value, text.c_str());
  else if (!gst_value_deserialize_with_pspec(value, text.c_str(), spec))
    return refused_value(element, spec, text);
  return ok();
}

// Matches GStreamer's messages:
//   no property "NAME" in element "FACTORY"
//   could not set property "NAME" in element "FACTORY" to "VALUE"
std::optional<RefusedProperty> refused_property(const GError& error) {
  const bool unknown = g_error_matches(&error, GST_PARSE_ERROR, GST_PARSE_ERROR_NO_SUCH_PROPERTY);
  const bool unusable =
      g_error_matches(&error, GST_PARSE_ERROR, GST_PARSE_ERROR_COULD_NOT_SET_PROPERTY);
  const auto parts = split(error.message, "\"", 6);
  if ((!unknown && !unusable) || parts.size() < (unusable ? 6 : 4)) return std::nullopt;
  GstElement* made = gst_element_factory_make(std::string(parts[3]).c_str(), nullptr);
  if (!made) return std::nullopt;
  const auto element = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(made)));
  const std::string property(parts[1]);
  const auto spec = find_property(element.get(), property);
  if (!spec) {
    Error missing = spec.error();
    missing.fix = "gst-inspect-1.0 " + kind_of(element.get());
    return RefusedProperty{property, std::nullopt, std::move(missing)};
  }
  if (unknown) return std::nullopt;
  const std::string value(parts[5].substr(0, parts[5].rfind('"')));
  return RefusedProperty{property, value, refused_value(element.get(), *spec, value)};
}

}  // namespace weir::gst
