// The properties of elements that differ from their defaults.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <string_view>

#include "report.hpp"

namespace weir::app {

// The names of the bins that hold an object, from the pipeline on, and its own:
// "pipeline0/decodebin0/typefind".
std::string get_path(GstObject* object);

// The class of an element, as gst-inspect-1.0 shows it: "Codec/Muxer". Valid as long as the
// element.
std::string_view get_class(GstElement* element);

// {"pipeline0/cast": {"mode": "typecast", ...}, ...} of the elements in a pipeline, also of those
// in bins. Without secrets, and without "name", "stats" and objects.
Json changed_properties(GstElement* pipeline);

}  // namespace weir::app
