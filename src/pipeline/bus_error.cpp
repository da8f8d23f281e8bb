// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/bus_error.hpp"

#include <string>

#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/posted_error.hpp"
#include "gstcpp/element/property_text.hpp"

namespace weir::pipeline {
namespace {

Code to_code(const GError& error) {
  if (error.domain == GST_RESOURCE_ERROR)
    return error.code == GST_RESOURCE_ERROR_OPEN_WRITE || error.code == GST_RESOURCE_ERROR_WRITE
               ? Code::FILE_NOT_WRITTEN
               : Code::FILE_NOT_FOUND;
  if (error.domain == GST_STREAM_ERROR) return Code::FORMAT_UNSUPPORTED;
  if (error.domain == GST_LIBRARY_ERROR && error.code == GST_LIBRARY_ERROR_SETTINGS)
    return Code::OPTION_VALUE;
  if (error.domain == GST_CORE_ERROR && error.code == GST_CORE_ERROR_NEGOTIATION)
    return Code::NOT_NEGOTIATED;
  return Code::INTERNAL;
}

// The text between the last quotes of a message; "" if there are none.
std::string quoted(const std::string& message) {
  const size_t end = message.rfind('"');
  const size_t begin = end == std::string::npos || end == 0 ? end : message.rfind('"', end - 1);
  return begin == std::string::npos || begin == end ? ""
                                                    : message.substr(begin + 1, end - begin - 1);
}

}  // namespace

BusError to_error(GstMessage* message) {
  const std::string element = GST_MESSAGE_SRC_NAME(message);
  auto posted = gst::read_posted_error(message);
  if (!posted.known)
    return {.error = {.code = to_code(*posted.original),
                      .what = element + ": " + printable_text(posted.original->message),
                      .offered = printable_text(posted.debug)}};
  posted.known->what = element + ": " + posted.known->what;
  return {.error = *std::move(posted.known), .has_code = true};
}

Error parse_error(const GError& error, const char* text) {
  if (auto refused = gst::refused_property(error)) return std::move(refused->error);
  Error out{.code = Code::OPTION_SYNTAX,
            .what = std::string("the pipeline description cannot be parsed: ") + error.message,
            .offered = text,
            .needed = "a description that gst-launch-1.0 accepts"};
  if (g_error_matches(&error, GST_PARSE_ERROR, GST_PARSE_ERROR_LINK)) {
    out.needed = "elements that fit together; weir run names the missing one";
    out.fix = "weir run " + shell_word(text);
  }
  if (g_error_matches(&error, GST_PARSE_ERROR, GST_PARSE_ERROR_NO_SUCH_ELEMENT)) {
    const std::string word = quoted(error.message);
    const std::string close = word.empty() ? "" : nearest(word, gst::installed_elements());
    out.code = Code::OPTION_VALUE;
    out.needed = "elements that are installed";
    out.difference = close.empty() ? "" : "did you mean " + close + "?";
    out.fix = "gst-inspect-1.0";
  }
  return out;
}

}  // namespace weir::pipeline
