// PostedError: an error or a warning that an element posted on the bus.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

struct PostedError {
  std::optional<Error> ours;              // all parts, if post_error() or post_warning() posted it
  Unique<GError, g_error_free> original;  // domain, code and text
  std::string debug;                      // "" if there is none
};

// Reads a message of the type ERROR or WARNING.
inline PostedError read_posted_error(GstMessage* message) {
  GError* original = nullptr;
  char* debug = nullptr;
  const GstStructure* details = nullptr;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
    gst_message_parse_error(message, &original, &debug);
    gst_message_parse_error_details(message, &details);
  } else {
    gst_message_parse_warning(message, &original, &debug);
    gst_message_parse_warning_details(message, &details);
  }
  const UniqueText owned(debug);
  PostedError out{{}, Unique<GError, g_error_free>(original), debug ? debug : ""};
  guint code = 0;
  if (!details || !gst_structure_has_name(details, "weir-error") ||
      !gst_structure_get_uint(details, "code", &code))
    return out;
  const auto part = [details](const char* name) {
    const char* text = gst_structure_get_string(details, name);
    return std::string(text ? text : "");
  };
  out.ours = Error{.code = static_cast<Code>(code),
                   .what = part("what"),
                   .offered = part("offered"),
                   .needed = part("needed"),
                   .difference = part("difference"),
                   .fix = part("fix")};
  return out;
}

}  // namespace weir::gst
