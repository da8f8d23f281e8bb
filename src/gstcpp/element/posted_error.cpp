// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/posted_error.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"

namespace weir::gst {
namespace {

namespace fs = std::filesystem;

std::string_view find_factory_name(GstObject* object) {
  if (!GST_IS_ELEMENT(object)) return "";
  GstElementFactory* factory = gst_element_get_factory(GST_ELEMENT(object));
  return factory ? GST_OBJECT_NAME(factory) : "";
}

// The value of a property of text; "" if the element has none.
std::string read_text(GstObject* element, const char* property) {
  const GParamSpec* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), property);
  if (!spec || spec->value_type != G_TYPE_STRING || !(spec->flags & G_PARAM_READABLE)) return "";
  char* text = nullptr;
  g_object_get(element, property, &text, nullptr);
  const UniqueText owned(text);
  return text ? text : "";
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
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(GST_ELEMENT(element), "sink"));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_uri());
  if (!pad || !gst_pad_peer_query(pad.get(), query.get())) return "";
  char* uri = nullptr;
  gst_query_parse_uri(query.get(), &uri);
  const UniqueText owned(uri);
  const UniqueText path(uri ? g_filename_from_uri(uri, nullptr, nullptr) : nullptr);
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
  const auto factory = find_factory_name(element);
  if (factory == "typefind" &&
      (g_error_matches(error, GST_STREAM_ERROR, GST_STREAM_ERROR_TYPE_NOT_FOUND) ||
       g_error_matches(error, GST_STREAM_ERROR, GST_STREAM_ERROR_WRONG_TYPE)))
    return format_error(element);
  if (error->domain != GST_RESOURCE_ERROR || (factory != "filesrc" && factory != "filesink"))
    return std::nullopt;
  const std::string location = read_text(element, "location");
  if (location.empty()) return std::nullopt;
  return factory == "filesrc" ? source_error(element, location) : sink_error(location);
}

// The address that an element connects to, as its properties, without login and query; "" for
// elements whose own text is complete, and for those that listen.
std::string read_address(GstObject* element) {
  const auto factory = find_factory_name(element);
  if (factory == "tcpclientsrc" || factory == "tcpclientsink") {
    gint port = 0;
    g_object_get(element, "port", &port, nullptr);
    return "host=" + read_text(element, "host") + " port=" + std::to_string(port);
  }
  if (factory != "rtspsrc") return "";
  const Unique<GUri, g_uri_unref> uri(
      g_uri_parse(read_text(element, "location").c_str(), G_URI_FLAGS_PARSE_RELAXED, nullptr));
  if (!uri) return "";
  const auto hidden = static_cast<GUriHideFlags>(G_URI_HIDE_USERINFO | G_URI_HIDE_QUERY);
  return "location=" + std::string(UniqueText(g_uri_to_string_partial(uri.get(), hidden)).get());
}

std::optional<Error> address_error(GstObject* element, const GError* error,
                                   const std::string& details) {
  const bool is_open =
      g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_OPEN_READ) ||
      g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_OPEN_WRITE) ||
      g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_OPEN_READ_WRITE);
  const std::string address = is_open && element ? read_address(element) : "";
  if (address.empty()) return std::nullopt;
  return Error{
      .code = Code::SERVER_UNREACHABLE,
      .what = "the address cannot be opened",
      .offered = address,
      .needed = "a server that listens there, a name that is known, and a network that leads to it",
      .difference = details};
}

// Without the place in GStreamer's source before it: "../gst/file.c(12): function ():
// /GstPipeline:p/...:\n".
std::string without_source_place(const std::string& debug) {
  const size_t function = debug.find(" (): /");
  const size_t line = debug.find('\n');
  if (function == std::string::npos || debug.rfind("): ", function) == std::string::npos ||
      line < function)
    return debug;
  return line == std::string::npos ? "" : debug.substr(line + 1);
}

std::optional<Error> error_from_details(const GstStructure* details) {
  guint code = 0;
  if (!gst_structure_get_uint(details, "code", &code)) return std::nullopt;
  const auto part = [details](const char* name) {
    const char* text = gst_structure_get_string(details, name);
    return std::string(text ? text : "");
  };
  return Error{.code = static_cast<Code>(code),
               .what = part("what"),
               .offered = part("offered"),
               .needed = part("needed"),
               .difference = part("difference"),
               .fix = part("fix")};
}

}  // namespace

PostedError read_posted_error(GstMessage* message) {
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
  PostedError out{
      {}, Unique<GError, g_error_free>(original), without_source_place(debug ? debug : "")};
  GstObject* const element = GST_MESSAGE_SRC(message);
  if (details && gst_structure_has_name(details, "weir-error")) {
    out.known = error_from_details(details);
  } else {
    out.known = file_error(element, original);
    if (!out.known) out.known = address_error(element, original, out.debug);
  }
  return out;
}

}  // namespace weir::gst
