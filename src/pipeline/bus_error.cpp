// Maps GStreamer's error domains to Weir's codes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/bus_error.hpp"

#include <string>
#include <vector>

#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/property_text.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::pipeline {
namespace {

std::string text_of(const GstStructure* s, const char* field) {
  const char* text = gst_structure_get_string(s, field);
  return text ? text : "";
}

Code code_of(const GError& error) {
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

std::vector<std::string> element_names() {
  std::vector<std::string> out;
  GList* all = gst_registry_get_feature_list(gst_registry_get(), GST_TYPE_ELEMENT_FACTORY);
  for (GList* at = all; at; at = at->next)
    out.emplace_back(gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(at->data)));
  gst_plugin_feature_list_free(all);
  return out;
}

// The text between the last quotes of a message; "" if there are none.
std::string quoted(const std::string& message) {
  const size_t end = message.rfind('"');
  const size_t begin = end == std::string::npos || end == 0 ? end : message.rfind('"', end - 1);
  return begin == std::string::npos || begin == end ? ""
                                                    : message.substr(begin + 1, end - begin - 1);
}

}  // namespace

Error error_of(GstMessage* message) {
  GError* raw = nullptr;
  gchar* debug = nullptr;
  gst_message_parse_error(message, &raw, &debug);
  const gst::Unique<GError, g_error_free> error(raw);
  const gst::UniqueText place(debug);
  const std::string element = GST_MESSAGE_SRC_NAME(message);
  const GstStructure* details = nullptr;
  gst_message_parse_error_details(message, &details);
  guint code = 0;
  if (details && gst_structure_has_name(details, "weir-error") &&
      gst_structure_get_uint(details, "code", &code))
    return Error{.code = static_cast<Code>(code),
                 .what = element + ": " + text_of(details, "what"),
                 .offered = text_of(details, "offered"),
                 .needed = text_of(details, "needed"),
                 .difference = text_of(details, "difference"),
                 .fix = text_of(details, "fix")};
  return Error{.code = code_of(*error),
               .what = element + ": " + printable_text(error->message),
               .offered = place ? printable_text(place.get()) : ""};
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
    const std::string close = word.empty() ? "" : nearest(word, element_names());
    out.code = Code::OPTION_VALUE;
    out.needed = "elements that are installed";
    out.difference = close.empty() ? "" : "did you mean " + close + "?";
    out.fix = "gst-inspect-1.0";
  }
  return out;
}

}  // namespace weir::pipeline
