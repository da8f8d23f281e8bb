// Explains why two elements of a pipeline's text cannot be linked, and what fits between them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "weir/result.hpp"

namespace weir::app {

// `message`: GStreamer's, "could not link A to B" or "could not link A to B, B can't handle caps
// CAPS". The error's fix is the whole text with an element that converts the stream, where one
// does. nullopt when the link is not found in the text.
std::optional<Error> refused_link(const std::string& text, const std::string& message);

}  // namespace weir::app
