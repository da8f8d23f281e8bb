// Finds a link of a pipeline's text to a pad that its element cannot have.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>

#include "weir/result.hpp"

namespace weir::app {

// Compares the names after a dot, as sink_0 in "mux.sink_0", with the pad templates of the
// elements. `parsed` is what GStreamer made of the text, or null: GStreamer accepts any name for a
// pad that appears while the pipeline plays, and then never links it. The error has the pads of the
// element, and the text with the nearest of them as its fix.
std::optional<Error> missing_pad(const std::string& text, GstElement* parsed);

}  // namespace weir::app
