// Errors and warnings as GStreamer messages.
#pragma once
#include <gst/gst.h>

#include "weir/result.hpp"

namespace weir::gst {

// Posts an error message on the element's bus: the GStreamer domain that fits the code, the whole
// text, and a details structure "weir-error" with code (uint), id ("WEIR-2001"), what, offered,
// needed, difference, fix (strings).
void post_error(GstElement* element, const Error& error);
void post_warning(GstElement* element, const Error& error);
// OPTION_VALUE: the property cannot change to `value` while the element is PAUSED or PLAYING.
Error property_is_fixed(const char* name, const GValue* value);

// While one lives, its element answers an event or a query in this thread. Sources try refused caps
// again: of errors over caps, the very one that was posted last is not posted again until caps are
// taken or forget_refusal().
class CapsTrial {
 public:
  CapsTrial(GstElement* element, GstEvent* event)
      : CapsTrial(element, GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {}
  CapsTrial(GstElement* element, GstQuery* query)
      : CapsTrial(element, GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS ||
                               GST_QUERY_TYPE(query) == GST_QUERY_CAPS) {}
  CapsTrial(const CapsTrial&) = delete;
  CapsTrial& operator=(const CapsTrial&) = delete;
  ~CapsTrial();
  // Gives `taken` back, the answer to an event.
  gboolean ended(gboolean taken);

 private:
  CapsTrial(GstElement* element, bool of_caps);

  GstElement* const element_;  // null: it is not about caps
  GstElement* const outer_;    // what was tried in this thread before
};
void forget_refusal(GstElement* element);
// How many there were, those that CapsTrial kept back too: whether a call into other elements ended
// in an error that was told.
uint64_t errors_posted_by_this_thread() noexcept;

}  // namespace weir::gst
