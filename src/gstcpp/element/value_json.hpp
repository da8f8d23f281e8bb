// Values of GObject as JSON, for properties such as "stats".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <nlohmann/json_fwd.hpp>

namespace weir::gst {

// Structures become objects, arrays and lists become arrays; numbers, booleans and strings are
// themselves, enums their nicks, and other types the text of gst_value_serialize(). null where
// there is no text.
nlohmann::ordered_json json_from_value(const GValue* value);
nlohmann::ordered_json json_from_structure(const GstStructure* structure);

}  // namespace weir::gst
