// Tests of the event that carries zones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/zones_event.hpp"

#include <gtest/gtest.h>

namespace weir::gst {
namespace zones_event_test {

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

}  // namespace zones_event_test
}  // namespace weir::gst
