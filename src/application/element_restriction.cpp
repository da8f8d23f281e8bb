// SPDX-License-Identifier: LGPL-2.1-or-later
#include "element_restriction.hpp"

#include <gst/gst.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <string_view>

#include "core/config/nnstreamer.hpp"
#include "core/text/launch_elements.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::application {
namespace {

// Logs them once per process.
void log_faults(const config::NnstreamerConfiguration& configuration) {
  static std::once_flag reported;
  if (configuration.faults().empty()) return;
  std::call_once(reported, [&configuration] {
    for (const auto& fault : configuration.faults())
      std::fprintf(stderr, "weir: configuration: %s\n", fault.message().c_str());
  });
}

bool exists(const std::string& factory) {
  GstElementFactory* const found = gst_element_factory_find(factory.c_str());
  if (found) gst_object_unref(found);
  return found != nullptr;
}

bool is_own(const std::string& factory) {
  GstElementFactory* const found = gst_element_factory_find(factory.c_str());
  if (!found) return false;
  const char* const name = gst_plugin_feature_get_plugin_name(GST_PLUGIN_FEATURE(found));
  const std::string_view plugin(name ? name : "");
  gst_object_unref(found);
  return plugin.starts_with("weir") || plugin.starts_with("nnstreamer");
}

}  // namespace

Result<ElementRestriction> ElementRestriction::read() {
  constexpr const char* kGroup = "element-restriction";
  const auto configuration = config::NnstreamerConfiguration::load();
  if (const auto& unread = configuration.unread()) {
    Error error = *unread;
    error.what = "a pipeline cannot be checked against [element-restriction]: " + error.what;
    return error;
  }
  log_faults(configuration);
  ElementRestriction out;
  const auto enabled = configuration.find(kGroup, "enable_element_restriction");
  if (!enabled || !config::truth(enabled->value, false)) return out;
  out.enabled_ = true;
  out.origin_ = enabled->origin;
  const auto elements = configuration.find(kGroup, "allowed_elements");
  if (!elements) return out;
  out.origin_ = elements->origin;
  for (const auto word : split(elements->value, ",; "))
    if (!strip(word).empty()) out.allowed_.emplace_back(strip(word));
  return out;
}

bool ElementRestriction::allows(const std::string& factory) const {
  if (!enabled_) return true;
  const bool is_listed = std::any_of(
      allowed_.begin(), allowed_.end(),
      [&](const std::string& allowed) { return equal_ignoring_case(allowed, factory); });
  return is_listed || is_own(factory);
}

Status ElementRestriction::check(const std::string& factory) const {
  if (allows(factory)) return ok();
  const std::string list = join(allowed_, ", ");
  return Error{.code = Code::OPTION_VALUE,
               .what = "the configuration does not allow this element in pipelines",
               .offered = factory,
               .needed = "an element of NNStreamer" + (list.empty() ? "" : ", or one of: " + list),
               .fix = "add the element to allowed_elements of [element-restriction] in " + origin_};
}

Status ElementRestriction::check_text(const char* text) const {
  if (!enabled_) return ok();
  for (const auto& factory : launch_elements(text).outside_bins)
    if (exists(factory))
      if (auto status = check(factory); !status) return status;
  return ok();
}

Status ElementRestriction::check_children(GstElement* pipeline) const {
  if (!enabled_) return ok();
  std::vector<std::string> factories;
  GST_OBJECT_LOCK(pipeline);
  for (const GList* at = GST_BIN_CHILDREN(pipeline); at; at = at->next) {
    GstElementFactory* const factory = gst_element_get_factory(GST_ELEMENT(at->data));
    factories.emplace_back(factory ? GST_OBJECT_NAME(factory) : G_OBJECT_TYPE_NAME(at->data));
  }
  GST_OBJECT_UNLOCK(pipeline);
  for (const auto& factory : factories)
    if (auto status = check(factory); !status) return status;
  return ok();
}

}  // namespace weir::application
