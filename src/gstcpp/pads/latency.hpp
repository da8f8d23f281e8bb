// Handles the LATENCY query of an element that holds frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir::gst {

// Queries upstream of `sink` and adds the element's own minimum and maximum latency.
inline gboolean handle_latency_query(GstPad* sink, GstQuery* query, GstClockTime own_min,
                                     GstClockTime own_max) {
  if (!gst_pad_peer_query(sink, query)) return FALSE;
  gboolean live = FALSE;
  GstClockTime min = 0, max = GST_CLOCK_TIME_NONE;
  gst_query_parse_latency(query, &live, &min, &max);
  gst_query_set_latency(query, live, min + own_min,
                        GST_CLOCK_TIME_IS_VALID(max) ? max + own_max : max);
  return TRUE;
}
inline gboolean handle_latency_query(GstPad* sink, GstQuery* query, GstClockTime own) {
  return handle_latency_query(sink, query, own, own);
}

}  // namespace weir::gst
