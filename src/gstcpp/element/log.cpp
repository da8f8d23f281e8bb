// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/log.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>

#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"
#include "weir/printable_text.hpp"

namespace weir::gst {
namespace {

GQuark category_quark() {
  static const GQuark quark = g_quark_from_static_string("weir-debug-category");
  return quark;
}

GstDebugLevel to_debug_level(int level) {
  switch (level) {
    case WEIR_LOG_ERROR:
      return GST_LEVEL_ERROR;
    case WEIR_LOG_WARNING:
      return GST_LEVEL_WARNING;
    case WEIR_LOG_INFO:
      return GST_LEVEL_INFO;
    default:
      return GST_LEVEL_DEBUG;
  }
}

bool is_module_name(std::string_view text) {
  return !text.empty() && text.size() <= 40 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

}  // namespace

GstDebugCategory* debug_category(const char* name, const char* description) {
  // GStreamer returns the category that already has this name.
  return _gst_debug_category_new(name, 0, description);
}

GstDebugCategory* library_category() {
  static GstDebugCategory* const category = debug_category("weir", "Weir: messages of the library");
  return category;
}

void set_category(GType type, GstDebugCategory* category) {
  g_type_set_qdata(type, category_quark(), category);
}

GstDebugCategory* get_category(GstElement* element) {
  auto* category =
      static_cast<GstDebugCategory*>(g_type_get_qdata(G_OBJECT_TYPE(element), category_quark()));
  return category ? category : library_category();
}

void log_output_caps(GstPad* source_pad, const GstCaps* caps) {
  const auto element = Ref<GstElement>::adopt(gst_pad_get_parent_element(source_pad));
  if (!element) return;
  GST_CAT_INFO_OBJECT(get_category(element.get()), source_pad, "output caps %" GST_PTR_FORMAT,
                      static_cast<const void*>(caps));
}

void log_module_line(int level, const char* module, const char* line) {
  const GstDebugLevel gst_level = to_debug_level(level);
  // No category shows this level: skips the search for the category.
  if (level > WEIR_LOG_WARNING && gst_level > _gst_debug_min) return;
  const std::string escaped = printable_text(line);
  const char* const text = escaped.c_str();
  const bool is_module = is_module_name(module);
  auto* const category =
      is_module ? debug_category((std::string("weir-") + module).c_str(), "a module of Weir")
                : library_category();
  const bool is_shown = gst_debug_category_get_threshold(category) >= gst_level;
  if (!is_shown && level <= WEIR_LOG_WARNING)
    std::fprintf(stderr, "weir: %s: %s\n", printable_text(module).c_str(), text);
  else if (is_module)
    GST_CAT_LEVEL_LOG(category, gst_level, nullptr, "%s", text);
  else
    GST_CAT_LEVEL_LOG(category, gst_level, nullptr, "%s: %s", printable_text(module).c_str(), text);
}

}  // namespace weir::gst
