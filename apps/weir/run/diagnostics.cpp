// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/diagnostics.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string_view>

#include "colour.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/posted_error.hpp"
#include "run/element_properties.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

std::string_view get_factory(GstObject* object) {
  if (!GST_IS_ELEMENT(object)) return "";
  GstElementFactory* factory = gst_element_get_factory(GST_ELEMENT(object));
  return factory ? GST_OBJECT_NAME(factory) : "";
}

std::string get_location(GstObject* element) {
  char* text = nullptr;
  g_object_get(element, "location", &text, nullptr);
  std::string out = text ? text : "";
  g_free(text);
  return out;
}

std::string similar_file(const fs::path& path) {
  std::error_code ignored;
  std::vector<std::string> names;
  for (const auto& entry :
       fs::directory_iterator(path.has_parent_path() ? path.parent_path() : fs::path("."), ignored))
    if (entry.is_regular_file(ignored)) names.push_back(entry.path().filename().string());
  return nearest(path.filename().string(), names);
}

// Whether the user wrote it, and no bin such as uridecodebin made it.
bool is_in_pipeline(GstObject* source) {
  return GST_OBJECT_PARENT(source) && GST_IS_PIPELINE(GST_OBJECT_PARENT(source));
}

Error folder_error(Code code, const std::string& location) {
  return Error{.code = code,
               .what = "the location is a folder",
               .offered = "location=" + location,
               .needed = "the path of a file, such as " + (fs::path(location) / "NAME").string()};
}

std::optional<Error> source_error(GstObject* source, const std::string& location) {
  std::error_code ignored;
  if (fs::is_directory(location, ignored)) return folder_error(Code::FILE_NOT_FOUND, location);
  if (fs::exists(location, ignored)) return std::nullopt;
  Error out{.code = Code::FILE_NOT_FOUND,
            .what = "the file does not exist",
            .offered = "location=" + location,
            .needed = "the path of a file"};
  const std::string close = similar_file(location);
  if (close.empty()) return out;
  out.difference = "did you mean " + close + "?";
  if (is_in_pipeline(source))
    out.fix = "location=" + launch_value((fs::path(location).parent_path() / close).string());
  return out;
}

std::optional<Error> sink_error(const std::string& location) {
  std::error_code ignored;
  const fs::path folder = fs::path(location).parent_path();
  if (fs::is_directory(location, ignored)) return folder_error(Code::FILE_NOT_WRITTEN, location);
  if (folder.empty() || fs::exists(folder, ignored)) return std::nullopt;
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "the folder of the file does not exist",
               .offered = "location=" + location,
               .needed = "a path in a folder that exists",
               .fix = "mkdir -p " + shell_word(folder.string())};
}

// The file that an element's sink pad reads; "" if the stream comes from elsewhere.
std::string find_input_file(GstObject* element) {
  const auto pad =
      gst::Ref<GstPad>::adopt(gst_element_get_static_pad(GST_ELEMENT(element), "sink"));
  const gst::Unique<GstQuery, gst_query_unref> query(gst_query_new_uri());
  if (!pad || !gst_pad_peer_query(pad.get(), query.get())) return "";
  char* uri = nullptr;
  gst_query_parse_uri(query.get(), &uri);
  const gst::UniqueText owned(uri);
  const gst::UniqueText path(uri ? g_filename_from_uri(uri, nullptr, nullptr) : nullptr);
  return path ? path.get() : "";
}

std::optional<Error> format_error(GstObject* typefind) {
  const std::string file = find_input_file(typefind);
  if (file.empty()) return std::nullopt;
  std::error_code failed;
  const bool is_empty = fs::file_size(file, failed) == 0 && !failed;
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = is_empty ? "the file is empty" : "the format of the file is not known",
               .offered = file,
               .needed = "a picture, a video or a sound"};
}

// The file that is the reason for an error of GStreamer's elements: of a filesrc whose file does
// not exist or is a folder, of a filesink whose file is a folder or lies in none that exists, and
// of a typefind that does not know the format of a file.
std::optional<Error> file_error(GstObject* element, const GError* error) {
  if (!error || !element) return std::nullopt;
  const auto factory = get_factory(element);
  if (factory == "typefind" &&
      (g_error_matches(error, GST_STREAM_ERROR, GST_STREAM_ERROR_TYPE_NOT_FOUND) ||
       g_error_matches(error, GST_STREAM_ERROR, GST_STREAM_ERROR_WRONG_TYPE)))
    return format_error(element);
  if (error->domain != GST_RESOURCE_ERROR || (factory != "filesrc" && factory != "filesink"))
    return std::nullopt;
  const std::string location = get_location(element);
  if (location.empty()) return std::nullopt;
  return factory == "filesrc" ? source_error(element, location) : sink_error(location);
}

// Video sinks of X, GL and Wayland post this error when their window is closed.
bool is_closed_window(GstObject* source, const GError* error) {
  if (!g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NOT_FOUND)) return false;
  if (!GST_IS_ELEMENT(source)) return false;
  const char* klass = gst_element_get_metadata(GST_ELEMENT(source), GST_ELEMENT_METADATA_KLASS);
  return klass && std::string_view(klass).find("Sink/Video") != std::string_view::npos;
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
  auto error = posted.ours ? std::move(posted.ours) : file_error(source, original);
  const bool has_code = error.has_value();
  return {.error = has_code ? *std::move(error) : Error{.what = original ? original->message : ""},
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
