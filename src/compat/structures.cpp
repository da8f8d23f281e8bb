// Compares structures of tensor caps; trailing 1s in dimensions are ignored.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/guard.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"
#include "nnstreamer_plugin_api.h"

using namespace weir::compat;

namespace {

// Returns the field with the dimensions; null if the structure is not a tensor stream.
const char* dimension_field(const GstStructure* structure) {
  if (gst_structure_has_name(structure, "other/tensor")) return "dimension";
  return gst_structure_has_name(structure, "other/tensors") ? "dimensions" : nullptr;
}

// Returns the spelling of the dimensions of `structure` in `other`; null if they are not equal.
const char* equal_dimensions(const GstStructure* structure, const GstStructure* other) {
  const char* field = dimension_field(structure);
  if (!field || !gst_structure_has_name(other, gst_structure_get_name(structure))) return nullptr;
  const char* own = gst_structure_get_string(structure, field);
  const char* text = gst_structure_get_string(other, field);
  return own && text && gst_tensor_dimension_string_is_equal(own, text) ? text : nullptr;
}

bool can_meet(const GstStructure* one, const GstStructure* other) {
  if (gst_structure_can_intersect(one, other)) return true;
  const char* spelling = equal_dimensions(one, other);
  if (!spelling) return false;
  const weir::gst::Unique<GstStructure, gst_structure_free> spelled{gst_structure_copy(one)};
  gst_structure_set(spelled.get(), dimension_field(one), G_TYPE_STRING, spelling, nullptr);
  return gst_structure_can_intersect(spelled.get(), other);
}

}  // namespace

gboolean gst_structure_is_tensor_stream(const GstStructure* structure) {
  return given(__func__, {structure}) && dimension_field(structure) != nullptr;
}

media_type gst_structure_get_media_type(const GstStructure* structure) {
  if (!given(__func__, {structure})) return _NNS_MEDIA_INVALID;
  return static_cast<media_type>(weir::media_type_of_caps_name(gst_structure_get_name(structure)));
}

gboolean gst_tensor_caps_can_intersect(GstCaps* caps1, GstCaps* caps2) {
  if (!given(__func__, {caps1, caps2})) return FALSE;
  if (gst_caps_can_intersect(caps1, caps2)) return TRUE;
  for (guint i = 0; i < gst_caps_get_size(caps1); ++i)
    for (guint k = 0; k < gst_caps_get_size(caps2); ++k)
      if (can_meet(gst_caps_get_structure(caps1, i), gst_caps_get_structure(caps2, k))) return TRUE;
  return FALSE;
}

void gst_tensor_caps_update_dimension(GstCaps* caps, GstCaps* filter) {
  if (!given(__func__, {caps, filter})) return;
  if (!gst_caps_is_writable(caps)) return warn(__func__, "the caps are not writable");
  for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
    GstStructure* structure = gst_caps_get_structure(caps, i);
    for (guint k = 0; k < gst_caps_get_size(filter); ++k)
      if (const char* text = equal_dimensions(structure, gst_caps_get_structure(filter, k)))
        gst_structure_set(structure, dimension_field(structure), G_TYPE_STRING, text, nullptr);
  }
}
