// Access to a pipeline's elements by name: valves, selectors, properties as text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "gstcpp/element/property_text.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::pipeline {

using gst::get_factory_name;

// An element at the top level of the bin before one of a bin in it. OPTION_VALUE, listing the
// existing names.
Result<gst::Ref<GstElement>> find_element(GstBin* bin, const std::string& name);
// OPTION_VALUE: a call cannot choose between `count` elements.
Error not_unique(const std::string& name, size_t count);
// OPTION_VALUE: the element is not of the kind `needed`.
Error wrong_kind(GstElement* element, const std::string& needed);

Status set_valve(GstElement* element, bool open);
Status select_pad(GstElement* element, const std::string& pad);
Status set_property(GstElement* element, const std::string& property, const std::string& text);
// Whether the property has this value.
bool has_value(GstElement* element, const std::string& property, const std::string& text);
Result<std::string> get_property(GstElement* element, const std::string& property);
// The value as JSON, as gst::json_from_value() converts it.
Result<std::string> get_property_json(GstElement* element, const std::string& property);
// Returns a weir_property_type.
Result<int> property_type(GstElement* element, const std::string& property);
// OPTION_VALUE when the property is not an enum.
Result<int> get_enum(GstElement* element, const std::string& property);

}  // namespace weir::pipeline
