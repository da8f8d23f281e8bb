// The property config-file: a text file that sets properties of an element.
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::gst {

// Sets each property that the file names (specification 4.1): bool by "true" in any case, else
// false; numbers by their leading digits; texts as they are. Unknown keys, properties that cannot
// be written and config-file itself are passed over; `passed_over` (may be null) gets a warning
// for each of the first two. FILE_NOT_FOUND when it cannot be read.
Status set_properties_from_file(GObject* object, const std::string& path,
                                std::vector<Error>* passed_over = nullptr);

}  // namespace weir::gst
