// Looks at the location and into its folder.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/missing_file.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/text/pasted.hpp"
#include "core/text/text.hpp"

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

}  // namespace

void explain_missing_file(GstObject* element, const GError* error, Complaint* complaint) {
  if (!error || error->domain != GST_RESOURCE_ERROR || !element) return;
  const auto factory = factory_of(element);
  if (factory != "filesrc" && factory != "filesink") return;
  const std::string location = location_of(element);
  if (location.empty()) return;
  if (factory == "filesrc")
    explain_source(element, location, complaint);
  else
    explain_sink(location, complaint);
}

}  // namespace weir::app
