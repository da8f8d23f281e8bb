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
  // Of post_error() and post_warning(), all parts. An error of GStreamer's elements about a file
  // becomes FILE_NOT_FOUND, FILE_NOT_WRITTEN or FORMAT_UNSUPPORTED, with the file and a similar
  // name; one about an address that cannot be opened becomes SERVER_UNREACHABLE.
  std::optional<Error> known;
  Unique<GError, g_error_free> original;  // domain, code and text
  std::string debug;                      // without the place in the source; "" if there is none
};

// Reads a message of the type ERROR or WARNING.
PostedError read_posted_error(GstMessage* message);

}  // namespace weir::gst
