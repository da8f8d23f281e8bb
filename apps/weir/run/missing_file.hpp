// Names the file that a filesrc cannot open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "run/pipeline_run.hpp"

namespace weir::app {

// If `source` is a filesrc whose file does not exist or is a folder, `complaint` becomes WEIR-4001
// with a similar name of the folder.
void explain_missing_file(GstObject* source, const GError* error, Complaint* complaint);

}  // namespace weir::app
