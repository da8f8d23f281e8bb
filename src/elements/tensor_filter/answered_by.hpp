// The custom meta "WeirAnsweredBy", which says who computed a frame: a string field for each filter
// that the frame went through and that may be answered from several places. The field has the name
// of the element; its value is the address of a server, several with commas for a frame in parts,
// or the path of the fallback. A model in this process needs no field.
//
//   GstCustomMeta* meta = gst_buffer_get_custom_meta(buffer, "WeirAnsweredBy");
//   gst_structure_get_string(gst_custom_meta_get_structure(meta), "filter0");
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

namespace weir {

// Makes the meta known, so that programs may ask for it before the first frame.
void register_answered_by();

// Sets the field of `element`. Does nothing if `who` is "".
void set_answered_by(GstBuffer* buffer, GstElement* element, const std::string& who);

}  // namespace weir
