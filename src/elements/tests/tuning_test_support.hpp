// Tuned: an element in a harness whose properties are set as text during playback and read back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "elements/tests/element_test_support.hpp"

namespace weir::test {

// The first element of this kind in the pipeline.
class Tuned {
 public:
  Tuned(const char* factory, const std::string& line, const std::string& caps)
      : harness(make_harness(line, caps)),
        element(find_element(harness, factory)),
        messages(harness) {}

  void set(const char* property, const char* value) {
    gst_util_set_object_arg(G_OBJECT(element.get()), property, value);
  }
  // "NULL" for a null string.
  std::string get(const char* property) {
    GParamSpec* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element.get()), property);
    GValue value = G_VALUE_INIT;
    g_value_init(&value, spec->value_type);
    g_object_get_property(G_OBJECT(element.get()), property, &value);
    std::string out = "NULL";
    if (G_VALUE_HOLDS_STRING(&value)) {
      if (const char* text = g_value_get_string(&value)) out = text;
    } else {
      out = gst::UniqueText(gst_value_serialize(&value)).get();
    }
    g_value_unset(&value);
    return out;
  }
  // The output for a frame.
  template <class Out = uint8_t, class In = uint8_t>
  std::vector<Out> push(const std::vector<In>& in) {
    if (gst_harness_push(harness.get(), frame<In>(in)) != GST_FLOW_OK) return {};
    const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(harness.get()));
    return out ? values<Out>(out.get()) : std::vector<Out>{};
  }
  std::string caps() const { return caps_text(harness); }

  Harness harness;
  Ref<GstElement> element;
  Errors messages;
};

}  // namespace weir::test
