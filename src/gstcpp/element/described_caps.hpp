// Caps of a query's filter that describe tensors and leave the format open
// (docs/compatibility/types-and-caps.md 1.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Returns the caps with format=static where a structure has the number, the dimensions or the types
// of tensors but no format: a pad that takes flexible tensors too offers one structure for them, so
// that a capsfilter upstream has fixed caps. Null for null.
Ref<GstCaps> static_where_described(GstCaps* filter);

// Handles a query with `handle`, which gets the filter of a CAPS query in this form.
template <class Handle>
gboolean with_static_filter(GstQuery* query, Handle&& handle) {
  GstCaps* filter = nullptr;
  if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS) gst_query_parse_caps(query, &filter);
  const auto described = static_where_described(filter);
  if (described.get() == filter) return handle(query);
  const Unique<GstQuery, gst_query_unref> own{gst_query_new_caps(described.get())};
  if (!handle(own.get())) return FALSE;
  GstCaps* result = nullptr;
  gst_query_parse_caps_result(own.get(), &result);
  gst_query_set_caps_result(query, result);
  return TRUE;
}

// A query function for pads of which only this differs from GStreamer's default.
gboolean query_with_static_filter(GstPad* pad, GstObject* parent, GstQuery* query);

}  // namespace weir::gst
