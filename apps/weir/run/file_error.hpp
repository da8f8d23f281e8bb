// Names the file that is the reason for an error of GStreamer's elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "run/pipeline_run.hpp"

namespace weir::app {

// If `element` is a filesrc whose file does not exist or is a folder, `complaint` becomes WEIR-4001
// with a similar name of the folder. If it is a filesink whose file is a folder or lies in none
// that exists, `complaint` becomes WEIR-4010. If it is a typefind that does not know the format of
// a file, `complaint` becomes WEIR-2002.
void explain_file_error(GstObject* element, const GError* error, Complaint* complaint);

}  // namespace weir::app
