// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the page of an element is, for gst-inspect-1.0.
#include "gstcpp/element/documentation.hpp"

#include <string>

namespace weir::gst {

void set_documentation_link(GstElementClass* element, const char* factory_name) {
  // The layout of the installed documents is that of the repository, so that their links work.
  const std::string page = std::string(WEIR_DOC_URL "/src/elements/") + factory_name + "/README.md";
  gst_element_class_add_metadata(element, GST_ELEMENT_METADATA_DOC_URI, page.c_str());
}

}  // namespace weir::gst
