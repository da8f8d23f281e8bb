// max-bytes of elements with several inputs: how much they hold, and the error when the streams
// need more.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_mux/many_inputs_test_support.hpp"

namespace weir::test {
namespace max_bytes_test {

Bytes zeros(size_t size) {
  return Bytes(size, 0);
}

TEST(MaxBytes, LimitsTheBytesThatMuxAndMergeHold) {
  for (const char* line : {"tensor_mux max-bytes=40", "tensor_merge option=0 max-bytes=40"}) {
    ManyInputs element(line);
    element.add(caps_of_bytes(10).c_str());
    element.add(caps_of_bytes(10).c_str());
    element.play();
    for (GstClockTime n = 0; n < 3; ++n) {
      auto first = element.push_later(0, zeros(10), n);
      EXPECT_EQ(element.push(1, zeros(10), n), GST_FLOW_OK) << line;
      EXPECT_EQ(first.get(), GST_FLOW_OK) << line;
    }
    EXPECT_EQ(element.error(), "");
    EXPECT_EQ(element.stat("bytes-held"), 20u);
    EXPECT_EQ(element.stat("bytes-most"), 40u) << "two frames that are used again, two new ones";
  }
}

TEST(MaxBytes, ReportsTheNeededBytes) {
  for (const char* line : {"tensor_mux max-bytes=19", "tensor_merge option=0 max-bytes=19"}) {
    ManyInputs element(line);
    element.add(caps_of_bytes(10).c_str());
    element.add(caps_of_bytes(10).c_str());
    element.play();
    auto first = element.push_later(0, zeros(10), 0);
    element.wait_for_stat("bytes-held", 10);
    EXPECT_EQ(element.push(1, zeros(10), 0), GST_FLOW_ERROR) << line;
    EXPECT_EQ(first.get(), GST_FLOW_ERROR) << line;
    const std::string text = element.error();
    EXPECT_SAYS(text, "WEIR-2006: the frames of one output exceed max-bytes");
    EXPECT_SAYS(text, "offered: 10 bytes held and a frame of 10 in addition, max-bytes=19");
    EXPECT_SAYS(text, "fix: max-bytes=20");
    EXPECT_EQ(element.stat("dropped-error"), 2u);
    EXPECT_EQ(element.stat("held"), 0u);
  }
}

TEST(MaxBytes, ReportsTheNeededBytesForCrop) {
  ManyInputs crop("tensor_crop max-bytes=30");
  crop.add(caps_of_bytes(40).c_str(), "raw");
  crop.add("other/tensors,format=flexible,framerate=30/1", "info");
  crop.play();
  auto raw = crop.push_later(0, zeros(40), 0);  // a single buffer may exceed the limit
  crop.wait_for_stat("bytes-held", 40);
  EXPECT_EQ(crop.push(1, zeros(144), 0), GST_FLOW_ERROR);
  EXPECT_EQ(raw.get(), GST_FLOW_ERROR);
  EXPECT_SAYS(crop.error(), "fix: max-bytes=184");
}

}  // namespace max_bytes_test
}  // namespace weir::test
