// Elements that can use an MQTT broker, in a build without libmosquitto: the error names what is
// missing, and streams without a broker work.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"

namespace edge_without_broker_test {

using namespace weir::test;

constexpr char kBroker[] = " dest-host=127.0.0.1 dest-port=1883 topic=objects";

TEST(WithoutABroker, TheErrorNamesTheLibrary) {
  for (const std::string element :
       {"edgesink port=0 connect-type=HYBRID", "edgesink port=0 connect-type=MQTT",
        "edgesrc connect-type=HYBRID", "edgesrc connect-type=MQTT",
        "tensor_query_client port=0 connect-type=HYBRID"}) {
    const std::string error = start_error(element + kBroker);
    EXPECT_SAYS(error, "this build of Weir cannot connect to MQTT brokers");
    EXPECT_SAYS(error, "offered: the broker 127.0.0.1:1883");
    EXPECT_SAYS(error, "fix: apt-get install libmosquitto-dev, then build Weir again");
  }
}

TEST(WithoutABroker, AServerNamesTheLibraryWhenItPlays) {
  const auto server =
      lone_element(std::string("tensor_query_serversrc port=0 connect-type=HYBRID") + kBroker);
  Errors errors(server.get());
  EXPECT_EQ(gst_element_set_state(server.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_FAILURE);
  EXPECT_SAYS(errors.next(), "apt-get install libmosquitto-dev");
  gst_element_set_state(server.get(), GST_STATE_NULL);
}

TEST(WithoutABroker, ThereAreNoElementsForMqtt) {
  for (const char* name : {"mqttsink", "mqttsrc"})
    EXPECT_EQ(Ref<GstElementFactory>::adopt(gst_element_factory_find(name)).get(), nullptr);
}

TEST(WithoutABroker, StreamsOverTcpWork) {
  const auto out =
      make_harness("edgesink sync=false port=0 wait-connection=true",
                   "other/tensor,dimension=(string)4,type=(string)uint8,framerate=30/1");
  guint port = 0;
  gst_structure_get_uint(stats(find_element(out, "edgesink").get()).get(), "port", &port);
  const Harness in{gst_harness_new_parse(("edgesrc dest-port=" + std::to_string(port)).c_str())};
  gst_harness_play(in.get());
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{7, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_TRUE(Ref<GstBuffer>::adopt(gst_harness_pull(in.get())));
}

}  // namespace edge_without_broker_test
