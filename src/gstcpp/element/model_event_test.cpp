// Tests the event "weir-model": what it carries, and what is not accepted from other elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/model_event.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace weir::gst {
namespace element_model_event_test {

DescribedModel whole_model() {
  DescribedModel model;
  model.inputs.push_back(
      {.type = ElementType::UInt8, .rank_known = true, .shape = {1, -1, -1, 3}, .name = "images"});
  model.outputs.push_back({.type = ElementType::Int8,
                           .rank_known = true,
                           .shape = {1, 84, 8400},
                           .name = "output0; \"quoted\", <odd>",
                           .scale = 0.0625f,
                           .zero_point = -3});
  model.outputs.push_back({.type = ElementType::End, .shape = {}, .name = {}});
  model.path = "/models/yolo.onnx";
  model.metadata_json = R"({"names": "{0: 'person'}"})";
  return model;
}

TEST(ModelEvent, CarriesTheModelDownstreamAndStaysOnPads) {
  const auto event = make_model_event(whole_model());
  EXPECT_EQ(GST_EVENT_TYPE(event.get()), GST_EVENT_CUSTOM_DOWNSTREAM_STICKY);
  const auto flags = gst_event_type_get_flags(GST_EVENT_TYPE(event.get()));
  EXPECT_TRUE(flags & GST_EVENT_TYPE_STICKY);
  EXPECT_TRUE(flags & GST_EVENT_TYPE_SERIALIZED);
  ASSERT_TRUE(is_model_event(event.get()));
  EXPECT_EQ(parse_model_event(event.get()), whole_model());
  EXPECT_EQ(parse_model_event(make_model_event({}).get()), DescribedModel{});
}

TEST(ModelEvent, OtherEventsAreNone) {
  const auto other = Ref<GstEvent>::adopt(gst_event_new_custom(
      GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, gst_structure_new_empty("weir-models")));
  const auto passing = Ref<GstEvent>::adopt(
      gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty("weir-model")));
  const auto eos = Ref<GstEvent>::adopt(gst_event_new_eos());
  for (const auto& event : {other, passing, eos}) {
    EXPECT_FALSE(is_model_event(event.get()));
    EXPECT_FALSE(parse_model_event(event.get()));
  }
}

// A valid event after `change` of its structure, or of its first output's.
std::optional<DescribedModel> changed(void (*change)(GstStructure* event)) {
  const auto event = make_model_event(whole_model());
  GstStructure* copy = gst_structure_copy(gst_event_get_structure(event.get()));
  change(copy);
  return parse_model_event(
      Ref<GstEvent>::adopt(gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, copy)).get());
}
std::optional<DescribedModel> changed_output(void (*change)(GstStructure* tensor)) {
  const auto event = make_model_event(whole_model());
  GstStructure* copy = gst_structure_copy(gst_event_get_structure(event.get()));
  GValue list = G_VALUE_INIT, item = G_VALUE_INIT;
  g_value_init(&list, GST_TYPE_ARRAY);
  g_value_init(&item, GST_TYPE_STRUCTURE);
  GstStructure* tensor = gst_structure_copy(gst_value_get_structure(
      gst_value_array_get_value(gst_structure_get_value(copy, "outputs"), 0)));
  change(tensor);
  g_value_take_boxed(&item, tensor);
  gst_value_array_append_and_take_value(&list, &item);
  gst_structure_take_value(copy, "outputs", &list);
  return parse_model_event(
      Ref<GstEvent>::adopt(gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, copy)).get());
}
void set_list(GstStructure* structure, const char* field, guint items, GType type) {
  GValue list = G_VALUE_INIT;
  g_value_init(&list, GST_TYPE_ARRAY);
  for (guint i = 0; i < items; ++i) {
    GValue item = G_VALUE_INIT;
    g_value_init(&item, type);
    gst_value_array_append_and_take_value(&list, &item);
  }
  gst_structure_take_value(structure, field, &list);
}

TEST(ModelEvent, NonsenseIsNotAccepted) {
  EXPECT_TRUE(changed([](GstStructure*) {}));
  EXPECT_TRUE(changed([](GstStructure* s) {
    gst_structure_set(s, "more", G_TYPE_INT, 1, nullptr);
  })) << "later versions may add fields";
  EXPECT_FALSE(changed([](GstStructure* s) { gst_structure_remove_all_fields(s); }));
  EXPECT_FALSE(changed([](GstStructure* s) { gst_structure_remove_field(s, "version"); }));
  EXPECT_FALSE(changed([](GstStructure* s) { gst_structure_remove_field(s, "outputs"); }));
  EXPECT_FALSE(
      changed([](GstStructure* s) { gst_structure_set(s, "version", G_TYPE_UINT, 2u, nullptr); }));
  EXPECT_FALSE(
      changed([](GstStructure* s) { gst_structure_set(s, "path", G_TYPE_INT, 1, nullptr); }));
  EXPECT_FALSE(changed(
      [](GstStructure* s) { gst_structure_set(s, "inputs", G_TYPE_STRING, "none", nullptr); }));
  EXPECT_FALSE(changed([](GstStructure* s) { set_list(s, "inputs", 1, G_TYPE_INT); }));
  EXPECT_FALSE(changed([](GstStructure* s) { set_list(s, "inputs", 1, GST_TYPE_STRUCTURE); }))
      << "a null structure";
  EXPECT_FALSE(changed([](GstStructure* s) { set_list(s, "inputs", 257, GST_TYPE_STRUCTURE); }));
}

TEST(ModelEvent, NonsenseOfATensorIsNotAccepted) {
  EXPECT_TRUE(changed_output([](GstStructure*) {}));
  EXPECT_FALSE(changed_output([](GstStructure* s) { gst_structure_remove_field(s, "shape"); }));
  EXPECT_FALSE(changed_output([](GstStructure* s) { gst_structure_remove_field(s, "scale"); }));
  EXPECT_FALSE(changed_output([](GstStructure* s) { set_list(s, "shape", 17, G_TYPE_INT64); }));
  EXPECT_FALSE(changed_output([](GstStructure* s) { set_list(s, "shape", 2, G_TYPE_STRING); }));
  EXPECT_FALSE(changed_output(
      [](GstStructure* s) { gst_structure_set(s, "type", G_TYPE_STRING, "complex64", nullptr); }));
  EXPECT_FALSE(changed_output(
      [](GstStructure* s) { gst_structure_set(s, "zero-point", G_TYPE_STRING, "0", nullptr); }));
  EXPECT_FALSE(changed_output([](GstStructure* s) {
    gst_structure_set(s, "scale", G_TYPE_DOUBLE, std::numeric_limits<double>::quiet_NaN(), nullptr);
  }));
  EXPECT_FALSE(changed_output([](GstStructure* s) {
    gst_structure_set(s, "scale", G_TYPE_DOUBLE, 1e300, nullptr);
  })) << "infinite as float32";
  EXPECT_FALSE(changed_output([](GstStructure* s) {
    gst_structure_set(s, "name", G_TYPE_STRING, std::string(5000, 'n').c_str(), nullptr);
  }));
  EXPECT_FALSE(changed_output([](GstStructure* s) {
    GValue list = G_VALUE_INIT, item = G_VALUE_INIT;
    g_value_init(&list, GST_TYPE_ARRAY);
    g_value_init(&item, G_TYPE_INT64);
    g_value_set_int64(&item, -2);
    gst_value_array_append_and_take_value(&list, &item);
    gst_structure_take_value(s, "shape", &list);
  }));
}

}  // namespace element_model_event_test
}  // namespace weir::gst
