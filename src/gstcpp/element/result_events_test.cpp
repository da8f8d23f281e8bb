// Tests of the events with names of classes and zones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "gstcpp/element/result_events.hpp"

namespace weir::gst {
namespace result_events_test {

const LabelsOfSource kTwo{"yolo nano;v1", {"person", "traffic \"light\"", ""}};

// A valid event after `change` of its structure.
std::optional<LabelsOfSource> changed(void (*change)(GstStructure* event)) {
  const auto event = make_labels_event(kTwo);
  GstStructure* copy = gst_structure_copy(gst_event_get_structure(event.get()));
  change(copy);
  return parse_labels_event(
      Ref<GstEvent>::adopt(gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, copy)).get());
}

TEST(LabelsEvent, CarriesTheLabelsOfASourceAndStaysOnPads) {
  const auto event = make_labels_event(kTwo);
  EXPECT_EQ(GST_EVENT_TYPE(event.get()), GST_EVENT_CUSTOM_DOWNSTREAM_STICKY);
  EXPECT_EQ(parse_labels_event(event.get()), kTwo);
  EXPECT_EQ(parse_labels_event(make_labels_event({}).get()), LabelsOfSource{});
}

// A pad keeps one sticky event of each name.
TEST(LabelsEvent, OfEachSourceHasAName) {
  const auto name_of = [](const char* source) {
    const auto event = make_labels_event({source, {}});
    return std::string(gst_structure_get_name(gst_event_get_structure(event.get())));
  };
  EXPECT_EQ(name_of("yolox_nano"), "weir-labels/yolox_nano");
  EXPECT_EQ(name_of("a b.c"), "weir-labels/a.20b.2ec");
  EXPECT_NE(name_of("a b"), name_of("a_b"));
  EXPECT_EQ(name_of("\xc3\xa9"), "weir-labels/.c3.a9");
}

TEST(LabelsEvent, OtherEventsAreNone) {
  const auto other = Ref<GstEvent>::adopt(gst_event_new_custom(
      GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, gst_structure_new_empty("weir-label")));
  const auto empty = Ref<GstEvent>::adopt(gst_event_new_custom(
      GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, gst_structure_new_empty("weir-labels/a")));
  const auto eos = Ref<GstEvent>::adopt(gst_event_new_eos());
  for (const auto& event : {other, empty, eos}) EXPECT_FALSE(parse_labels_event(event.get()));
}

TEST(LabelsEvent, OtherContentsAreNone) {
  EXPECT_TRUE(changed([](GstStructure*) {}));
  EXPECT_FALSE(
      changed([](GstStructure* s) { gst_structure_set(s, "version", G_TYPE_UINT, 2u, nullptr); }));
  EXPECT_FALSE(changed([](GstStructure* s) { gst_structure_remove_field(s, "source"); }));
  EXPECT_FALSE(changed(
      [](GstStructure* s) { gst_structure_set(s, "labels", G_TYPE_STRING, "person", nullptr); }));
  EXPECT_FALSE(changed([](GstStructure* s) {
    gst_structure_set(s, "source", G_TYPE_STRING, std::string(4097, 'x').c_str(), nullptr);
  }));
  EXPECT_FALSE(changed([](GstStructure* s) {
    GValue list = G_VALUE_INIT, number = G_VALUE_INIT;
    g_value_init(&list, GST_TYPE_ARRAY);
    g_value_init(&number, G_TYPE_INT);
    gst_value_array_append_and_take_value(&list, &number);
    gst_structure_take_value(s, "labels", &list);
  }));
}

TEST(ZonesEvent, ReadsBack) {
  const ZonesOfSource zones{"zones of \"a\"", "{\"version\":1,\n\"zones\":[]}"};
  const auto event = make_zones_event(zones);
  EXPECT_EQ(parse_zones_event(event.get()), zones);
  EXPECT_EQ(GST_EVENT_TYPE(event.get()), GST_EVENT_CUSTOM_DOWNSTREAM_STICKY);
}

TEST(ZonesEvent, OtherContentsAreIgnored) {
  for (const char* text : {"other, version=(uint)1, source=(string)a, zones=(string)b;",
                           "weir-zones, version=(uint)2, source=(string)a, zones=(string)b;",
                           "weir-zones, source=(string)a, zones=(string)b;",
                           "weir-zones, version=(uint)1, source=(int)1, zones=(string)b;",
                           "weir-zones, version=(uint)1, source=(string)a;"}) {
    const auto event = Ref<GstEvent>::adopt(gst_event_new_custom(
        GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, gst_structure_from_string(text, nullptr)));
    EXPECT_FALSE(parse_zones_event(event.get())) << text;
  }
  const auto eos = Ref<GstEvent>::adopt(gst_event_new_eos());
  EXPECT_FALSE(parse_zones_event(eos.get()));
}

}  // namespace result_events_test
}  // namespace weir::gst
