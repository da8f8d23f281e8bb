// Explains which links of a pipeline's text GStreamer cannot make, and what fits instead.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>

#include "weir/result.hpp"

namespace weir::app {

// `message`: GStreamer's, "could not link A to B" or "could not link A to B, B can't handle caps
// CAPS". The error's fix is the whole text with an element that converts the stream, where one
// does. nullopt when the link is not found in the text.
std::optional<Error> refused_link(const std::string& text, const std::string& message);

// Finds two elements that follow each other: the first one has no output and the second
// one no input: a ! was forgotten, which GStreamer accepts. The fix is the text with it.
std::optional<Error> missing_link(const std::string& text);

// Finds dimensions of two numbers, "dimensions=640:3", in caps: GStreamer reads them as flags
// unless (string) comes first. The fix is the text with it.
std::optional<Error> dimensions_without_type(const std::string& text);

// Finds a link to a pad that its element cannot have. Compares the names after a dot, as sink_0 in
// "mux.sink_0", with the pad templates of the elements. `parsed` is what GStreamer made of the
// text, or null: GStreamer accepts any name for a pad that appears while the pipeline plays, and
// then never links it. The error has the pads of the element, and the text with the nearest of them
// as its fix.
std::optional<Error> missing_pad(const std::string& text, GstElement* parsed);

}  // namespace weir::app
