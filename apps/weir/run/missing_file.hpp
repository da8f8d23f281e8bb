// Names the file that a filesrc or filesink cannot open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "run/pipeline_run.hpp"

namespace weir::app {

// If `element` is a filesrc whose file does not exist or is a folder, `complaint` becomes WEIR-4001
// with a similar name of the folder. If it is a filesink whose file is a folder or lies in none
// that exists, `complaint` becomes WEIR-4010.
void explain_missing_file(GstObject* element, const GError* error, Complaint* complaint);

}  // namespace weir::app
