// SPDX-License-Identifier: LGPL-2.1-or-later
// The addresses of documents, for gst-inspect-1.0.
#pragma once

namespace weir::gst {

// The address of a document, which is named as in the sources ("README.md"): below the build option
// doc_url, or else the file that was installed with this plug-in, also where the tree was moved to
// since. Valid until the process ends.
const char* documentation_link(const char* page);

}  // namespace weir::gst
