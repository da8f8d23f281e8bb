// tensor_aggregator whose windows change while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/tuning_test_support.hpp"

namespace tensor_aggregator_tuning_test {

using namespace weir::test;

Tuned tuned(const std::string& line) {
  return {"tensor_aggregator", line, "other/tensor,dimension=(string)2,type=uint8,framerate=30/1"};
}

TEST(AggregatorPropertyChange, NewWindowAppliesToTheNextFrameAndKeepsWaitingFrames) {
  auto t = tuned("tensor_aggregator frames-out=2 frames-dim=0");
  EXPECT_EQ(t.push<>({1, 2}), Bytes{});
  EXPECT_EQ(t.push<>({3, 4}), (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(t.push<>({5, 6}), Bytes{});
  t.set("frames-out", "3");
  EXPECT_EQ(t.get("frames-out"), "3");
  EXPECT_EQ(t.push<>({7, 8}), Bytes{});
  EXPECT_EQ(t.push<>({9, 10}), (Bytes{5, 6, 7, 8, 9, 10}));
  EXPECT_SAYS(t.caps(), "dimensions=(string)6");
  t.set("frames-out", "1");
  EXPECT_EQ(t.push<>({11, 12}), (Bytes{11, 12}));
  EXPECT_SAYS(t.caps(), "dimensions=(string)2");
}

TEST(AggregatorPropertyChange, FlushAndConcatApply) {
  auto t = tuned("tensor_aggregator frames-out=2 frames-dim=0");
  EXPECT_EQ(t.push<>({1, 2}), Bytes{});
  t.set("frames-flush", "1");
  EXPECT_EQ(t.push<>({3, 4}), (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(t.push<>({5, 6}), (Bytes{3, 4, 5, 6}));
  t.set("concat", "false");
  t.set("frames-in", "2");
  t.set("frames-flush", "0");
  EXPECT_EQ(t.push<>({7, 8}).size(), 2u) << "two frames in each buffer are a window";
}

TEST(AggregatorPropertyChange, InvalidWindowIsRejectedAndRestored) {
  auto t = tuned(
      "tensor_aggregator frames-out=2 frames-dim=0 ! capsfilter "
      "caps=other/tensor,dimension=(string)4");
  EXPECT_EQ(t.push<>({1, 2}), Bytes{});
  t.set("frames-out", "3");
  EXPECT_EQ(t.push<>({3, 4}), (Bytes{1, 2, 3, 4}));
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-2001");
  EXPECT_EQ(t.get("frames-out"), "2");
  t.set("frames-in", "4");
  EXPECT_EQ(t.push<>({1, 2}), Bytes{});
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-");
  EXPECT_EQ(t.get("frames-in"), "1");
}

TEST(AggregatorPropertyChange, ADimensionBeyondTheRankIsRejectedAtOnce) {
  auto t = tuned("tensor_aggregator frames-out=2 frames-dim=0");
  EXPECT_EQ(t.push<>({1, 2}), Bytes{});
  t.set("frames-dim", "9");
  EXPECT_SAYS(t.messages.next_warning(),
              "WEIR-1004: frames-dim is beyond the dimensions of the tensors: the value was "
              "rejected, and the old one stays");
  EXPECT_EQ(t.get("frames-dim"), "0");
}

TEST(AggregatorPropertyChange, ASecondWriteCompletesTheFirst) {
  auto t = tuned(
      "tensor_aggregator frames-out=2 frames-dim=0 ! capsfilter "
      "caps=other/tensor,dimension=(string)4");
  EXPECT_EQ(t.push<>({1, 2}), Bytes{});
  t.set("frames-in", "2");
  EXPECT_EQ(t.push<>({3, 4}), (Bytes{1, 2, 3, 4}));
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-2001");
  EXPECT_EQ(t.get("frames-in"), "1");
  t.set("frames-out", "4");
  EXPECT_EQ(t.push<>({5, 6}), Bytes{});
  EXPECT_EQ(t.push<>({7, 8}), (Bytes{5, 6, 7, 8}));
  EXPECT_EQ(t.get("frames-in"), "2");
  EXPECT_EQ(t.get("frames-out"), "4");
  EXPECT_EQ(t.messages.next_warning(), "");
}

}  // namespace tensor_aggregator_tuning_test
