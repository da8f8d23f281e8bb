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

bool is_file_source(GstObject* object) {
  if (!GST_IS_ELEMENT(object)) return false;
  GstElementFactory* factory = gst_element_get_factory(GST_ELEMENT(object));
  return factory && std::string_view(GST_OBJECT_NAME(factory)) == "filesrc";
}

std::string location_of(GstObject* source) {
  char* text = nullptr;
  g_object_get(source, "location", &text, nullptr);
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

}  // namespace

void explain_missing_file(GstObject* source, const GError* error, Complaint* complaint) {
  if (!error || error->domain != GST_RESOURCE_ERROR || !source || !is_file_source(source)) return;
  const std::string location = location_of(source);
  std::error_code ignored;
  const bool is_folder = fs::is_directory(location, ignored);
  if (location.empty() || (!is_folder && fs::exists(location, ignored))) return;
  complaint->id = "WEIR-4001";
  complaint->what = is_folder ? "the location is a folder" : "the file does not exist";
  complaint->offered = "location=" + location;
  complaint->needed = "the path of a file";
  if (is_folder) {
    complaint->needed += ", such as " + (fs::path(location) / "NAME").string();
    return;
  }
  const std::string close = similar_file(location);
  if (close.empty()) return;
  complaint->difference = "did you mean " + close + "?";
  if (is_in_pipeline(source))
    complaint->fix =
        "location=" + launch_value((fs::path(location).parent_path() / close).string());
}

}  // namespace weir::app
