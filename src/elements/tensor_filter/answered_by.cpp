// Registers the meta and adds its fields.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/answered_by.hpp"

namespace weir {
namespace {

constexpr char kName[] = "WeirAnsweredBy";

}  // namespace

void register_answered_by() {
  static const auto* const info = [] {
    static const gchar* tags[] = {nullptr};
    return gst_meta_register_custom(kName, tags, nullptr, nullptr, nullptr);
  }();
  (void)info;
}

void set_answered_by(GstBuffer* buffer, GstElement* element, const std::string& who) {
  if (who.empty()) return;
  register_answered_by();
  GstCustomMeta* meta = gst_buffer_get_custom_meta(buffer, kName);
  if (!meta) meta = gst_buffer_add_custom_meta(buffer, kName);
  if (!meta) return;
  gst_structure_set(gst_custom_meta_get_structure(meta), GST_OBJECT_NAME(element), G_TYPE_STRING,
                    who.c_str(), nullptr);
}

}  // namespace weir
