// The addresses of documents, for gst-inspect-1.0.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir::gst {

// The address of a document, which is named as in the sources ("README.md"): below the build option
// doc_url, or else the file that was installed with this plug-in, also where the tree was moved to
// since. Valid until the process ends.
const char* documentation_link(const char* page);

// Sets the documentation link of an element's class: the address of its page below the build option
// doc_url.
void set_documentation_link(GstElementClass* element, const char* factory_name);

}  // namespace weir::gst
