// tensor_mux: a pad that is linked late, with frames older than those already used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_mux/many_inputs_test_support.hpp"

namespace weir::test {
namespace late_pad_test {

// Whether it returns while the other pads receive nothing.
bool returns(std::future<GstFlowReturn>& push) {
  return push.wait_for(kMaxWait) == std::future_status::ready;
}

TEST(TensorMuxLatePad, OldFramesDoNotWaitForTheOthers) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  for (uint8_t i = 0; i < 4; ++i) EXPECT_EQ(mux.push(0, Bytes{i}, i), GST_FLOW_OK);
  mux.add(caps_of_bytes(1).c_str());
  for (uint8_t i = 0; i < 3; ++i) {
    auto push = mux.push_later(1, Bytes{static_cast<uint8_t>(10 + i)}, i);
    EXPECT_TRUE(returns(push)) << "it waits for a frame that may be in a full queue";
    if (HasFailure()) mux.stop();
    EXPECT_EQ(push.get(), GST_FLOW_OK);
  }
  auto push = mux.push_later(1, Bytes{14}, 4);
  EXPECT_EQ(mux.push(0, Bytes{4}, 4), GST_FLOW_OK);
  EXPECT_EQ(push.get(), GST_FLOW_OK);
  ASSERT_EQ(mux.buffers().size(), 5u);
  EXPECT_EQ(read_memories(mux.buffers()[4].get()), (std::vector<Bytes>{{4}, {14}}));
  mux.stop();
  EXPECT_EQ(mux.stat("received"), 9u);
  EXPECT_EQ(mux.stat("consumed"), 6u);
  EXPECT_EQ(mux.stat("dropped-policy"), 3u);
}

// A frame with the time of the last output may still be used for the next one.
TEST(TensorMuxLatePad, AFrameOfTheLastTimeWaits) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  EXPECT_EQ(mux.push(0, Bytes{1}, 7), GST_FLOW_OK);
  mux.add(caps_of_bytes(1).c_str());
  auto push = mux.push_later(1, Bytes{2}, 7);
  mux.wait_for_stat("held", 1);
  EXPECT_EQ(mux.push(0, Bytes{3}, 7), GST_FLOW_OK);
  EXPECT_EQ(push.get(), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(1).get()), (std::vector<Bytes>{{3}, {2}}));
}

}  // namespace late_pad_test
}  // namespace weir::test
