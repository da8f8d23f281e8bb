// Answers the LATENCY query of an element that holds frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir::gst {

// Queries upstream of `sink` and adds the element's own minimum and maximum latency.
inline gboolean answer_latency(GstPad* sink, GstQuery* query, GstClockTime own_least,
                               GstClockTime own_most) {
  if (!gst_pad_peer_query(sink, query)) return FALSE;
  gboolean live = FALSE;
  GstClockTime least = 0, most = GST_CLOCK_TIME_NONE;
  gst_query_parse_latency(query, &live, &least, &most);
  gst_query_set_latency(query, live, least + own_least,
                        GST_CLOCK_TIME_IS_VALID(most) ? most + own_most : most);
  return TRUE;
}
inline gboolean answer_latency(GstPad* sink, GstQuery* query, GstClockTime own) {
  return answer_latency(sink, query, own, own);
}

}  // namespace weir::gst
