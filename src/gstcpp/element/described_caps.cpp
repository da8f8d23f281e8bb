// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/described_caps.hpp"

#include <algorithm>
#include <iterator>

namespace weir::gst {
namespace {

bool is_described(const GstStructure* structure) {
  static constexpr const char* kOfStaticTensors[] = {"num_tensors", "dimensions", "types"};
  return gst_structure_has_name(structure, "other/tensors") &&
         !gst_structure_has_field(structure, "format") &&
         std::any_of(std::begin(kOfStaticTensors), std::end(kOfStaticTensors),
                     [&](const char* field) { return gst_structure_has_field(structure, field); });
}

}  // namespace

Ref<GstCaps> static_where_described(GstCaps* filter) {
  auto result = Ref<GstCaps>::share(filter);
  if (!filter) return result;
  for (guint i = 0; i < gst_caps_get_size(filter); ++i) {
    if (!is_described(gst_caps_get_structure(filter, i))) continue;
    if (result.get() == filter) result = Ref<GstCaps>::adopt(gst_caps_copy(filter));
    gst_structure_set(gst_caps_get_structure(result.get(), i), "format", G_TYPE_STRING, "static",
                      nullptr);
  }
  return result;
}

gboolean query_with_static_filter(GstPad* pad, GstObject* parent, GstQuery* query) {
  return with_static_filter(
      query, [&](GstQuery* described) { return gst_pad_query_default(pad, parent, described); });
}

}  // namespace weir::gst
