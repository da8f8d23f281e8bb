// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/diagnostics.hpp"

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "colour.hpp"
#include "gstcpp/element/posted_error.hpp"
#include "run/element_properties.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

// Video sinks of X, GL and Wayland post this error when their window is closed.
bool is_closed_window(GstObject* source, const GError* error) {
  if (!g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NOT_FOUND)) return false;
  if (!GST_IS_ELEMENT(source)) return false;
  return get_class(GST_ELEMENT(source)).find("Sink/Video") != std::string_view::npos;
}

void print_complaint(const char* kind, Colour colour, const Diagnostic& diagnostic) {
  const Error& error = diagnostic.error;
  const std::string id = get_id(diagnostic);
  std::string head = kind;
  if (!diagnostic.element.empty()) head += " from " + diagnostic.element;
  // Other elements put text of peers and files into their errors as it is.
  std::string text = coloured(stderr, colour, printable_text(head)) + ": " +
                     (id.empty() ? "" : id + ": ") + printable_text(error.what) + "\n";
  const auto add = [&text](const char* name, const std::string& part) {
    if (!part.empty()) text += std::string("  ") + name + ": " + printable_text(part) + "\n";
  };
  add("offered", error.offered);
  add("needed", error.needed);
  add("first difference", error.difference);
  if (!error.fix.empty())
    text += coloured(stderr, Colour::Green, "  fix: " + printable_text(error.fix)) + "\n";
  // Weir's errors are complete without it; GStreamer's own elements put the useful part there.
  if (id.empty()) add("details", diagnostic.debug);
  std::fputs(text.c_str(), stderr);
}

}  // namespace

Diagnostic parse_diagnostic(GstMessage* message) {
  auto posted = gst::read_posted_error(message);
  const GError* original = posted.original.get();
  GstObject* source = GST_MESSAGE_SRC(message);
  const bool has_code = posted.known.has_value();
  return {.error = has_code ? *std::move(posted.known)
                            : Error{.what = original ? original->message : ""},
          .has_code = has_code,
          .element = source ? GST_OBJECT_NAME(source) : "",
          .path = source ? get_path(source) : "",
          .debug = std::move(posted.debug),
          .is_closed_window =
              GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR && is_closed_window(source, original)};
}

std::string get_id(const Diagnostic& diagnostic) {
  const int code = static_cast<int>(diagnostic.error.code);
  return diagnostic.has_code ? "WEIR-" + std::to_string(code) : "";
}

void print_warning(const Diagnostic& warning) {
  print_complaint("warning", Colour::Yellow, warning);
}

// If one of Weir's elements reports the cause, the errors of others only follow from it. A source
// that retries, such as with other caps, repeats the same error.
void print_errors(const std::vector<Diagnostic>& errors) {
  const auto ours = [](const Diagnostic& diagnostic) { return diagnostic.has_code; };
  const bool any_ours = std::any_of(errors.begin(), errors.end(), ours);
  for (auto error = errors.begin(); error != errors.end(); ++error) {
    const auto is_same = [&](const Diagnostic& other) {
      return other.path == error->path && other.debug == error->debug &&
             other.has_code == error->has_code && other.error.message() == error->error.message();
    };
    if ((!any_ours || ours(*error)) && std::none_of(errors.begin(), error, is_same))
      print_complaint("error", Colour::Red, *error);
  }
}

}  // namespace weir::app
