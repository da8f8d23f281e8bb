// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the page of an element is, for gst-inspect-1.0.
#pragma once

#include <gst/gst.h>

namespace weir::gst {

// Sets the documentation link of an element's class: the address of its page below the build option
// doc_url.
void set_documentation_link(GstElementClass* element, const char* factory_name);

}  // namespace weir::gst
