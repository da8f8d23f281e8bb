// Converts caps and structures from and to text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

using UniqueStructure = Unique<GstStructure, gst_structure_free>;

// gst_caps_from_string() overflows the stack and fails assertions on text made to do so: only text
// of our own may be given to it. OPTION_SYNTAX for text that is not caps or names types that caps
// do not have, LIMIT_EXCEEDED beyond the limits of core/text/caps_syntax.hpp.
Result<Ref<GstCaps>> caps_from_text(const std::string& text);
// The same for one structure, for example a parameter of a region.
Result<UniqueStructure> structure_from_text(const std::string& text);

// Returns the text of gst_caps_to_string().
std::string to_string(const GstCaps* caps);

}  // namespace weir::gst
