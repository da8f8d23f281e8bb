// Frames from user properties of MQTT 5.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/mqttsrc/received_frame.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace received_frame_test {

transport::MqttMessage message(std::vector<std::pair<std::string, std::string>> user) {
  transport::MqttMessage out;
  out.payload.resize(6);
  out.properties.user = std::move(user);
  return out;
}

TEST(MqttFrameHeader, MovesTimesByTheBaseEpochs) {
  const auto frame = frame_from_properties(message({{"caps", "a/b"},
                                                    {"pts", "5"},
                                                    {"base-epoch", "110"},
                                                    {"sent-epoch", "200"},
                                                    {"sizes", "2,4"}}),
                                           100);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pts, 15u);
  EXPECT_EQ(frame->sizes, (std::vector<size_t>{2, 4}));
}

TEST(MqttFrameHeader, RejectsPropertiesThatCannotBeRead) {
  EXPECT_REFUSED(frame_from_properties(message({}), 0), PEER_MESSAGE_INVALID, "has no caps");
  for (const char* name : {"pts", "dur", "seq", "base-epoch", "sent-epoch", "sizes"})
    EXPECT_REFUSED(frame_from_properties(message({{"caps", "a/b"}, {name, "x"}}), 0),
                   PEER_MESSAGE_INVALID, std::string(name) + "=\"x\"");
}

}  // namespace received_frame_test
}  // namespace weir
