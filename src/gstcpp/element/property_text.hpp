// Properties as text; errors for rejected names and values list the valid ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>

#include "weir/result.hpp"

namespace weir::gst {

class Value {
 public:
  explicit Value(GType type) { g_value_init(&value_, type); }
  Value(const Value&) = delete;
  Value& operator=(const Value&) = delete;
  ~Value() { g_value_unset(&value_); }
  GValue* get() noexcept { return &value_; }

 private:
  GValue value_ = G_VALUE_INIT;
};

// The factory name of the element, for example "valve".
std::string get_factory_name(GstElement* element);

// OPTION_VALUE, listing the valid names, when there is no such property.
Result<GParamSpec*> find_property(GstElement* element, const std::string& property);

// OPTION_VALUE: `text` is not a value of the property. Lists the values of an enum or flags.
Error refused_value(GstElement* element, GParamSpec* spec, const std::string& text);

// Parses `text` as a value of the property; `value` is initialised to its type. OPTION_VALUE as in
// refused_value().
Status read_value(GstElement* element, GParamSpec* spec, const std::string& text, GValue* value);

// The property that gst_parse_launch() rejected.
struct RefusedProperty {
  std::string property;
  std::optional<std::string> value;  // set if the property exists
  Error error;
  std::string nearest;  // the valid name or value that is closest; "" if none is
};
// nullopt when `error` is about something else.
std::optional<RefusedProperty> refused_property(const GError& error);

}  // namespace weir::gst
