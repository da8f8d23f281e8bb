// Asks the element for its file, and looks into its folder.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/file_error.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

std::string_view factory_of(GstObject* object) {
  if (!GST_IS_ELEMENT(object)) return "";
  GstElementFactory* factory = gst_element_get_factory(GST_ELEMENT(object));
  return factory ? GST_OBJECT_NAME(factory) : "";
}

std::string location_of(GstObject* element) {
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

void report_folder(const std::string& location, Complaint* complaint) {
  complaint->what = "the location is a folder";
  complaint->offered = "location=" + location;
  complaint->needed = "the path of a file, such as " + (fs::path(location) / "NAME").string();
}

void explain_source(GstObject* source, const std::string& location, Complaint* complaint) {
  std::error_code ignored;
  const bool is_folder = fs::is_directory(location, ignored);
  if (!is_folder && fs::exists(location, ignored)) return;
  complaint->id = "WEIR-4001";
  if (is_folder) return report_folder(location, complaint);
  complaint->what = "the file does not exist";
  complaint->offered = "location=" + location;
  complaint->needed = "the path of a file";
  const std::string close = similar_file(location);
  if (close.empty()) return;
  complaint->difference = "did you mean " + close + "?";
  if (is_in_pipeline(source))
    complaint->fix =
        "location=" + launch_value((fs::path(location).parent_path() / close).string());
}

void explain_sink(const std::string& location, Complaint* complaint) {
  std::error_code ignored;
  const fs::path folder = fs::path(location).parent_path();
  const bool is_folder = fs::is_directory(location, ignored);
  if (!is_folder && (folder.empty() || fs::exists(folder, ignored))) return;
  complaint->id = "WEIR-4010";
  if (is_folder) return report_folder(location, complaint);
  complaint->what = "the folder of the file does not exist";
  complaint->offered = "location=" + location;
  complaint->needed = "a path in a folder that exists";
  complaint->fix = "mkdir -p " + shell_word(folder.string());
}

// The file that an element's sink pad reads; "" if the stream comes from elsewhere.
std::string input_file_of(GstObject* element) {
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

void explain_format(GstObject* typefind, Complaint* complaint) {
  const std::string file = input_file_of(typefind);
  if (file.empty()) return;
  std::error_code failed;
  const bool is_empty = fs::file_size(file, failed) == 0 && !failed;
  complaint->id = "WEIR-2002";
  complaint->what = is_empty ? "the file is empty" : "the format of the file is not known";
  complaint->offered = file;
  complaint->needed = "a picture, a video or a sound";
}

}  // namespace

void explain_file_error(GstObject* element, const GError* error, Complaint* complaint) {
  if (!error || !element) return;
  const auto factory = factory_of(element);
  if (factory == "typefind" &&
      (g_error_matches(error, GST_STREAM_ERROR, GST_STREAM_ERROR_TYPE_NOT_FOUND) ||
       g_error_matches(error, GST_STREAM_ERROR, GST_STREAM_ERROR_WRONG_TYPE)))
    return explain_format(element, complaint);
  if (error->domain != GST_RESOURCE_ERROR || (factory != "filesrc" && factory != "filesink"))
    return;
  const std::string location = location_of(element);
  if (location.empty()) return;
  if (factory == "filesrc")
    explain_source(element, location, complaint);
  else
    explain_sink(location, complaint);
}

}  // namespace weir::app
