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

}  // namespace weir::gst
