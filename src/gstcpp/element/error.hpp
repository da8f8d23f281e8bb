// Posts errors and warnings as GStreamer messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>
#include <string>

#include "weir/result.hpp"

namespace weir::gst {

// Posts an error message on the element's bus, with the GStreamer domain that fits the code, the
// whole text, and a details structure "weir-error" with code (uint), id ("WEIR-2001"), what,
// offered, needed, difference, fix (strings).
void post_error(GstElement* element, const Error& error);
void post_warning(GstElement* element, const Error& error);
// NOT_NEGOTIATED: a buffer arrived before caps, on `pad` of an element with several pads.
Error buffer_before_caps(std::string fix = "put a capsfilter downstream of the source",
                         std::string pad = {});

// OPTION_VALUE: the property cannot change to `value` while the element is PAUSED or PLAYING.
Error property_is_fixed(const char* name, const GValue* value);

// Marks, for its scope, that this thread handles an event or query of the element. Sources retry
// rejected caps: the caps error posted last is not posted again until caps are accepted or
// forget_refusal() is called.
class CapsTrial {
 public:
  CapsTrial(GstElement* element, GstEvent* event);
  CapsTrial(GstElement* element, GstQuery* query)
      : CapsTrial(element, GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS ||
                               GST_QUERY_TYPE(query) == GST_QUERY_CAPS) {}
  CapsTrial(const CapsTrial&) = delete;
  CapsTrial& operator=(const CapsTrial&) = delete;
  ~CapsTrial();
  // Records the result of an event and returns it.
  gboolean ended(gboolean taken);

 private:
  CapsTrial(GstElement* element, bool of_caps);

  GstElement* const element_;  // null for other events and queries
  GstElement* const outer_;    // the enclosing trial of this thread
};
void forget_refusal(GstElement* element);
// Includes the errors that CapsTrial suppressed; shows whether a call into other elements posted an
// error.
uint64_t errors_posted_by_this_thread() noexcept;

}  // namespace weir::gst
