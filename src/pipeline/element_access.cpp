// Checks names and values before GObject does, which would only log a warning.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/element_access.hpp"

#include <nlohmann/json.hpp>

#include <utility>
#include <vector>

#include "core/text/error_text.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/value_json.hpp"
#include "gstcpp/pads/output_selector.hpp"
#include "weir/pipeline.h"

namespace weir::pipeline {
namespace {

using gst::find_property;
using gst::Value;

std::vector<std::string> names_in(GstBin* bin) {
  std::vector<std::string> out;
  for (const auto& element : gst::elements_in(GST_ELEMENT(bin)))
    out.emplace_back(GST_OBJECT_NAME(element.get()));
  return out;
}

// An element of the bin itself; null if there is none.
gst::Ref<GstElement> find_child(GstBin* bin, const std::string& name) {
  gst::Ref<GstElement> out;
  GST_OBJECT_LOCK(bin);
  for (GList* at = GST_BIN_CHILDREN(bin); at && !out; at = at->next)
    if (name == GST_OBJECT_NAME(at->data)) out = gst::Ref<GstElement>::share(GST_ELEMENT(at->data));
  GST_OBJECT_UNLOCK(bin);
  return out;
}

Error refused(GstElement* element, const GParamSpec& spec, const std::string& offered,
              std::string needed) {
  return Error{.code = Code::OPTION_VALUE,
               .what = get_factory_name(element) + " does not accept this value for " + spec.name,
               .offered = offered,
               .needed = std::move(needed),
               .fix = "gst-inspect-1.0 " + get_factory_name(element)};
}

Result<GParamSpec*> find_readable(GstElement* element, const std::string& property) {
  auto found = find_property(element, property);
  if (found && !((*found)->flags & G_PARAM_READABLE))
    return refused(element, **found, "", "a value: it is write-only");
  return found;
}

}  // namespace

Error wrong_kind(GstElement* element, const std::string& needed) {
  return Error{
      .code = Code::OPTION_VALUE,
      .what = std::string(GST_OBJECT_NAME(element)) + " is not an element that this call is for",
      .offered = get_factory_name(element),
      .needed = needed};
}

Error not_unique(const std::string& name, size_t count) {
  return {.code = Code::OPTION_VALUE,
          .what = std::to_string(count) + " elements of the pipeline have this name",
          .offered = "name=" + name + " in different bins",
          .needed = "a name of its own for each element",
          .fix = "name=" + name + "2 for one of them"};
}

Result<gst::Ref<GstElement>> find_element(GstBin* bin, const std::string& name) {
  if (auto child = find_child(bin, name)) return child;
  auto element = gst::Ref<GstElement>::adopt(gst_bin_get_by_name(bin, name.c_str()));
  if (element) return element;
  return not_one_of("no element of the pipeline has this name", name, names_in(bin));
}

Status set_valve(GstElement* element, bool open) {
  if (get_factory_name(element) != "valve") return wrong_kind(element, "valve");
  g_object_set(element, "drop", open ? FALSE : TRUE, nullptr);
  return ok();
}

Status select_pad(GstElement* element, const std::string& name) {
  const std::string kind = get_factory_name(element);
  const bool in = kind == "input-selector";
  if (!in && kind != "output-selector")
    return wrong_kind(element, "input-selector or output-selector");
  std::vector<std::string> names;
  gst::Ref<GstPad> found;
  GST_OBJECT_LOCK(element);
  for (GList* at = in ? element->sinkpads : element->srcpads; at; at = at->next) {
    names.emplace_back(GST_OBJECT_NAME(at->data));
    if (names.back() == name) found = gst::Ref<GstPad>::share(GST_PAD(at->data));
  }
  GST_OBJECT_UNLOCK(element);
  if (!found) return not_one_of(kind + " has no such pad", name, names);
  if (in)
    g_object_set(element, "active-pad", found.get(), nullptr);
  else
    gst::switch_output(found);
  return ok();
}

Status set_property(GstElement* element, const std::string& property, const std::string& text) {
  const auto found = find_property(element, property);
  if (!found) return found.error();
  GParamSpec* spec = *found;
  if (!(spec->flags & G_PARAM_WRITABLE) || (spec->flags & G_PARAM_CONSTRUCT_ONLY))
    return refused(element, *spec, text, "nothing: it is read-only");
  Value value(spec->value_type);
  if (auto status = gst::read_value(element, spec, text, value.get()); !status) return status;
  // Returns true when it had to correct a value out of range.
  if (g_param_value_validate(spec, value.get())) {
    const gst::UniqueText nearest_value(gst_value_serialize(value.get()));
    return refused(element, *spec, text,
                   std::string("a value in its range, such as ") +
                       (nearest_value ? nearest_value.get() : "the default"));
  }
  g_object_set_property(G_OBJECT(element), property.c_str(), value.get());
  return ok();
}

bool has_value(GstElement* element, const std::string& property, const std::string& text) {
  const auto found = find_readable(element, property);
  if (!found) return false;
  Value wanted((*found)->value_type), present((*found)->value_type);
  if (!gst::read_value(element, *found, text, wanted.get())) return false;
  g_object_get_property(G_OBJECT(element), property.c_str(), present.get());
  return gst_value_compare(wanted.get(), present.get()) == GST_VALUE_EQUAL;
}

Result<std::string> get_property(GstElement* element, const std::string& property) {
  const auto found = find_readable(element, property);
  if (!found) return found.error();
  Value value((*found)->value_type);
  g_object_get_property(G_OBJECT(element), property.c_str(), value.get());
  if (G_VALUE_HOLDS_STRING(value.get())) {
    const char* text = g_value_get_string(value.get());
    return std::string(text ? text : "");
  }
  gst::UniqueText text(gst_value_serialize(value.get()));
  if (!text) text.reset(g_strdup_value_contents(value.get()));
  return std::string(text ? text.get() : "");
}

Result<std::string> get_property_json(GstElement* element, const std::string& property) {
  const auto found = find_readable(element, property);
  if (!found) return found.error();
  Value value((*found)->value_type);
  g_object_get_property(G_OBJECT(element), property.c_str(), value.get());
  using Json = nlohmann::ordered_json;
  return gst::json_from_value(value.get()).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<int> property_type(GstElement* element, const std::string& property) {
  const auto found = find_property(element, property);
  if (!found) return found.error();
  const GType type = (*found)->value_type;
  constexpr std::pair<GType, int> kTypes[]{
      {G_TYPE_BOOLEAN, WEIR_PROPERTY_BOOL},  {G_TYPE_INT, WEIR_PROPERTY_INT32},
      {G_TYPE_UINT, WEIR_PROPERTY_UINT32},   {G_TYPE_INT64, WEIR_PROPERTY_INT64},
      {G_TYPE_UINT64, WEIR_PROPERTY_UINT64}, {G_TYPE_LONG, WEIR_PROPERTY_INT64},
      {G_TYPE_ULONG, WEIR_PROPERTY_UINT64},  {G_TYPE_DOUBLE, WEIR_PROPERTY_DOUBLE},
      {G_TYPE_FLOAT, WEIR_PROPERTY_DOUBLE},  {G_TYPE_STRING, WEIR_PROPERTY_STRING}};
  for (const auto& [known, number] : kTypes)
    if (known == type) return number;
  return static_cast<int>(G_TYPE_IS_ENUM(type) ? WEIR_PROPERTY_ENUM : WEIR_PROPERTY_OTHER);
}

Result<int> get_enum(GstElement* element, const std::string& property) {
  const auto found = find_property(element, property);
  if (!found) return found.error();
  if (!G_TYPE_IS_ENUM((*found)->value_type) || !((*found)->flags & G_PARAM_READABLE))
    return refused(element, **found, g_type_name((*found)->value_type),
                   "a property that is an enum and can be read");
  Value value((*found)->value_type);
  g_object_get_property(G_OBJECT(element), property.c_str(), value.get());
  return static_cast<int>(g_value_get_enum(value.get()));
}

}  // namespace weir::pipeline
