// Finds out which property gst_parse_launch() could not set and which values it takes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/property_text.hpp"

#include <sstream>
#include <vector>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

std::string value_not_accepted(GstElement* element, const GParamSpec* spec) {
  return get_factory_name(element) + " does not accept this value for " + spec->name;
}

std::vector<std::string> list_nicks(const GEnumClass* type) {
  std::vector<std::string> out;
  for (guint i = 0; i < type->n_values; ++i) out.emplace_back(type->values[i].value_nick);
  return out;
}
std::vector<std::string> list_nicks(const GFlagsClass* type) {
  std::vector<std::string> out;
  for (guint i = 0; i < type->n_values; ++i) out.emplace_back(type->values[i].value_nick);
  return out;
}

std::vector<std::string> list_properties(GstElement* element) {
  std::vector<std::string> out;
  guint count = 0;
  const Unique<GParamSpec*, g_free> all(
      g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count));
  for (guint i = 0; i < count; ++i) out.emplace_back(all.get()[i]->name);
  return out;
}

template <class Number>
std::string range_text(const char* kind, Number min, Number max) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << kind << " from " << +min << " to " << +max;
  return out.str();
}

// What a value of the property is, in words.
std::string needed_text(GParamSpec* spec) {
  constexpr char kWhole[] = "a whole number", kNumber[] = "a number";
  const auto range = [](const char* kind, const auto* of) {
    return range_text(kind, of->minimum, of->maximum);
  };
  if (G_IS_PARAM_SPEC_BOOLEAN(spec)) return "true or false";
  if (G_IS_PARAM_SPEC_INT(spec)) return range(kWhole, G_PARAM_SPEC_INT(spec));
  if (G_IS_PARAM_SPEC_UINT(spec)) return range(kWhole, G_PARAM_SPEC_UINT(spec));
  if (G_IS_PARAM_SPEC_INT64(spec)) return range(kWhole, G_PARAM_SPEC_INT64(spec));
  if (G_IS_PARAM_SPEC_UINT64(spec)) return range(kWhole, G_PARAM_SPEC_UINT64(spec));
  if (G_IS_PARAM_SPEC_FLOAT(spec)) return range(kNumber, G_PARAM_SPEC_FLOAT(spec));
  if (G_IS_PARAM_SPEC_DOUBLE(spec)) return range(kNumber, G_PARAM_SPEC_DOUBLE(spec));
  if (spec->value_type == GST_TYPE_FRACTION) return "a fraction, such as 30/1";
  if (spec->value_type == GST_TYPE_CAPS) return "caps, such as video/x-raw,format=RGB";
  return std::string("a value of the type ") + g_type_name(spec->value_type);
}

// The nearest valid value, "" if none is near.
std::string nearest_value(GParamSpec* spec, const std::string& text) {
  if (G_IS_PARAM_SPEC_ENUM(spec))
    return nearest(text, list_nicks(G_PARAM_SPEC_ENUM(spec)->enum_class));
  if (G_IS_PARAM_SPEC_FLAGS(spec))
    return nearest(text, list_nicks(G_PARAM_SPEC_FLAGS(spec)->flags_class));
  return "";
}

}  // namespace

std::string get_factory_name(GstElement* element) {
  GstElementFactory* factory = gst_element_get_factory(element);
  return factory ? gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory))
                 : G_OBJECT_TYPE_NAME(element);
}

Result<GParamSpec*> find_property(GstElement* element, const std::string& property) {
  auto* type = G_OBJECT_GET_CLASS(element);
  if (auto* spec = g_object_class_find_property(type, property.c_str())) return spec;
  return not_one_of(get_factory_name(element) + " has no such property", property,
                    list_properties(element));
}

Error refused_value(GstElement* element, GParamSpec* spec, const std::string& text) {
  Error out{.code = Code::OPTION_VALUE, .what = value_not_accepted(element, spec), .offered = text};
  if (G_IS_PARAM_SPEC_ENUM(spec)) {
    out = not_one_of(out.what, text, list_nicks(G_PARAM_SPEC_ENUM(spec)->enum_class));
  } else if (G_IS_PARAM_SPEC_FLAGS(spec)) {
    const auto nicks = list_nicks(G_PARAM_SPEC_FLAGS(spec)->flags_class);
    out = not_one_of(out.what, text, nicks);
    out.needed += "; join several with +";
  } else {
    out.needed = needed_text(spec);
  }
  out.fix = "gst-inspect-1.0 " + get_factory_name(element);
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
    missing.fix = "gst-inspect-1.0 " + get_factory_name(element.get());
    return RefusedProperty{property, std::nullopt, std::move(missing),
                           nearest(property, list_properties(element.get()))};
  }
  if (unknown) return std::nullopt;
  const std::string value(parts[5].substr(0, parts[5].rfind('"')));
  return RefusedProperty{property, value, refused_value(element.get(), *spec, value),
                         nearest_value(*spec, value)};
}

}  // namespace weir::gst
