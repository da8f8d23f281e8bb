// Checks pipeline descriptions: core parses the text, GStreamer's registry gives the elements
// behind properties and URI schemes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/allowed_elements.hpp"

#include <algorithm>

#include "core/text/launch_elements.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/property_text.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/join.hpp"

namespace weir::pipeline {
namespace {

constexpr int kDeepest = 16;  // nesting of descriptions in properties

Error forbidden(const std::string& factory, const std::vector<std::string>& allowed) {
  const std::string list = join(allowed, ", ");
  return Error{.code = Code::OPTION_VALUE,
               .what = "the configuration does not allow this element in pipelines",
               .offered = factory,
               .needed = "one of: " + (list.empty() ? "none" : list)};
}

// Whether the property of these elements takes an element, which GStreamer makes from text.
bool takes_element(const std::string& factory_name, const std::string& property) {
  const auto factory =
      gst::Ref<GstElementFactory>::adopt(gst_element_factory_find(factory_name.c_str()));
  if (!factory) return false;
  const auto loaded = gst::Ref<GstElementFactory>::adopt(
      GST_ELEMENT_FACTORY(gst_plugin_feature_load(GST_PLUGIN_FEATURE(factory.get()))));
  if (!loaded) return false;
  const gst::Unique<void, g_type_class_unref> type(
      g_type_class_ref(gst_element_factory_get_element_type(loaded.get())));
  const GParamSpec* spec =
      g_object_class_find_property(G_OBJECT_CLASS(type.get()), property.c_str());
  return spec && g_type_is_a(spec->value_type, GST_TYPE_ELEMENT);
}

// A "child::property" of a GstChildProxy whose child is unknown: it names an element if the value
// starts with an element's name.
bool may_name_element(const std::string& property, const std::string& value) {
  if (property.find("::") == std::string::npos) return false;
  const auto named = launch_elements(value);
  return std::any_of(named.factories.begin(), named.factories.end(), [](const auto& name) {
    return static_cast<bool>(
        gst::Ref<GstElementFactory>::adopt(gst_element_factory_find(name.c_str())));
  });
}

bool handles(GstElementFactory* factory, const std::string& scheme) {
  const gchar* const* known = gst_element_factory_get_uri_protocols(factory);
  for (; known && *known; ++known)
    if (g_ascii_strcasecmp(*known, scheme.c_str()) == 0) return true;
  return false;
}

}  // namespace

Status AllowedElements::check_name(const std::string& factory) const {
  if (factory == "bin" || factory == "pipeline" || factory == "capsfilter" ||
      std::find(factories_.begin(), factories_.end(), factory) != factories_.end())
    return ok();
  return forbidden(factory, factories_);
}

// GStreamer chooses by rank and has fallbacks: every element that handles the scheme must be
// allowed.
Status AllowedElements::check_scheme(const std::string& scheme) const {
  GList* all = gst_registry_get_feature_list(gst_registry_get(), GST_TYPE_ELEMENT_FACTORY);
  Status status = ok();
  for (GList* at = all; at && status; at = at->next)
    if (handles(GST_ELEMENT_FACTORY(at->data), scheme))
      status = check_name(GST_OBJECT_NAME(at->data));
  gst_plugin_feature_list_free(all);
  return status;
}

Status AllowedElements::check(std::string_view description) const {
  return check(description, 0);
}

Status AllowedElements::check(std::string_view description, int depth) const {
  const auto named = launch_elements(description);
  for (const auto& factory : named.factories)
    if (auto status = check_name(factory); !status) return status;
  for (const auto& scheme : named.uri_schemes)
    if (auto status = check_scheme(scheme); !status) return status;
  for (const auto& property : named.properties) {
    if (!takes_element(property.factory, property.name) &&
        !may_name_element(property.name, property.value))
      continue;
    if (depth == kDeepest) return forbidden(property.value, factories_);
    if (auto status = check(property.value, depth + 1); !status) return status;
  }
  return ok();
}

Status AllowedElements::check(GstElement* element) const {
  const std::string kind = gst::get_factory_name(element);
  // A bin without a factory was made by another element; only its children are checked.
  const std::string name = !kind.empty()         ? kind
                           : GST_IS_BIN(element) ? "bin"
                                                 : G_OBJECT_TYPE_NAME(element);
  if (auto status = check_name(name); !status) return status;
  return GST_IS_BIN(element) ? check(GST_BIN(element)) : ok();
}

Status AllowedElements::check(GstBin* bin) const {
  std::vector<gst::Ref<GstElement>> children;
  GST_OBJECT_LOCK(bin);
  for (GList* at = GST_BIN_CHILDREN(bin); at; at = at->next)
    children.push_back(gst::Ref<GstElement>::share(GST_ELEMENT(at->data)));
  GST_OBJECT_UNLOCK(bin);
  for (const auto& child : children)
    if (auto status = check(child.get()); !status) return status;
  return ok();
}

namespace {

void drop_all(GstElement*, GstPad* pad, gpointer) {
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_DATA_BOTH,
      [](GstPad*, GstPadProbeInfo*, gpointer) { return GST_PAD_PROBE_DROP; }, nullptr, nullptr);
}

}  // namespace

void disable(GstElement* element) {
  gst_element_set_locked_state(element, TRUE);
  g_signal_connect(element, "pad-added", G_CALLBACK(drop_all), nullptr);
  gst_element_foreach_pad(
      element,
      [](GstElement* of, GstPad* pad, gpointer) -> gboolean {
        drop_all(of, pad, nullptr);
        return TRUE;
      },
      nullptr);
  // The bin may have started it before the lock.
  gst_element_set_state(element, GST_STATE_NULL);
}

void AllowedElements::stop_others(GstBin* bin) const {
  for (const auto& element : gst::elements_in(GST_ELEMENT(bin)))
    if (!check(element.get())) gst_element_set_state(element.get(), GST_STATE_NULL);
}

}  // namespace weir::pipeline
