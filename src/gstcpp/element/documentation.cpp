// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the page of an element is, for gst-inspect-1.0.
#include "gstcpp/element/documentation.hpp"

#include <string>
#include <string_view>

#include "core/config/install_paths.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

// The layout of the installed documents is that of the repository, so that their links work.
std::string make_address(const std::string& page) {
  constexpr std::string_view kAddress = WEIR_DOC_URL;
  if (!kAddress.empty()) return std::string(kAddress) + "/" + page;
  const std::string file = std::string(config::installed_documents()) + "/" + page;
  const UniqueText address(g_filename_to_uri(file.c_str(), nullptr, nullptr));
  return address ? address.get() : "";
}

// The folder of a plug-in's elements.
std::string_view get_folder(std::string_view element) {
  if (element.ends_with("_grpc")) return "src/net-elements/";
  for (const std::string_view start : {"edge", "mqtt", "tensor_query_"})
    if (element.starts_with(start)) return "src/edge/";
  return "src/elements/";
}

}  // namespace

const char* documentation_link(const char* page) {
  return g_intern_string(make_address(page).c_str());
}

void set_documentation_link(GstElementClass* element, const char* factory_name) {
  const std::string page = std::string(get_folder(factory_name)) + factory_name + "/README.md";
  gst_element_class_add_static_metadata(element, GST_ELEMENT_METADATA_DOC_URI,
                                        documentation_link(page.c_str()));
}

}  // namespace weir::gst
