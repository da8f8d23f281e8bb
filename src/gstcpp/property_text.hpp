// Properties as users write them: names and words that are refused come back with those there are.
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

// The name of its factory: "valve".
std::string kind_of(GstElement* element);

// OPTION_VALUE with the names that there are.
Result<GParamSpec*> find_property(GstElement* element, const std::string& property);

// OPTION_VALUE: `text` is no value of the property. With the words of an enum or of flags.
Error refused_value(GstElement* element, GParamSpec* spec, const std::string& text);

// Reads `text` as a value of the property. OPTION_VALUE as refused_value(). `value` is initialised
// to the property's type.
Status read_value(GstElement* element, GParamSpec* spec, const std::string& text, GValue* value);

// The property that gst_parse_launch() refused.
struct RefusedProperty {
  std::string property;
  std::optional<std::string> value;  // of a property that is there
  Error error;
};
// Nothing where `error` is about something else.
std::optional<RefusedProperty> refused_property(const GError& error);

}  // namespace weir::gst
