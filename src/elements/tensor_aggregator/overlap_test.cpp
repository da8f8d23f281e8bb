// Overlapping windows: they share memory, each byte is copied about once, and none changes later.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <deque>
#include <random>

#include "elements/tests/element_test_support.hpp"

namespace overlap_test {

using namespace weir::test;

constexpr char kName[] = "tensor_aggregator";
constexpr size_t kFrame = 1000, kOut = 10;

Harness overlapping() {
  return make_harness("tensor_aggregator frames-out=10 frames-flush=1 frames-dim=1",
                      tensors("uint8", "1000:1"));
}
Bytes numbered(size_t number) {
  Bytes out(kFrame);
  for (size_t i = 0; i < kFrame; ++i) out[i] = static_cast<uint8_t>(number * 7 + i);
  return out;
}
void expect_window(GstBuffer* buffer, size_t begin) {
  Bytes expected;
  for (size_t i = begin; i < begin + kOut; ++i) {
    const Bytes one = numbered(i);
    expected.insert(expected.end(), one.begin(), one.end());
  }
  ASSERT_EQ(content(buffer), expected) << "window " << begin;
}

TEST(OverlappingWindows, CopyEachByteAboutOnce) {
  auto h = overlapping();
  constexpr size_t kFrames = 2000;
  for (size_t i = 0; i < kFrames; ++i) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(numbered(i))), GST_FLOW_OK);
    if (i + 1 < kOut) continue;
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    expect_window(out.get(), i + 1 - kOut);
  }
  const auto moved = static_cast<double>(stat(h, kName, "bytes-copied"));
  EXPECT_LE(moved, 1.2 * kFrames * kFrame);
  EXPECT_GE(moved, 1.0 * kFrames * kFrame);
}

TEST(OverlappingWindows, StayUnchangedWhenMoreFramesArrive) {
  auto h = overlapping();
  constexpr size_t kFrames = 300;
  std::vector<Ref<GstBuffer>> kept;
  for (size_t i = 0; i < kFrames; ++i) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(numbered(i))), GST_FLOW_OK);
    if (i + 1 >= kOut) kept.push_back(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())));
  }
  h.reset();  // the buffers outlive the element
  for (size_t i = 0; i < kept.size(); ++i) expect_window(kept[i].get(), i);
}

TEST(OverlappingWindows, CanBeHeldIndefinitely) {
  auto h = overlapping();
  std::mt19937 random(9);
  std::deque<std::pair<size_t, Ref<GstBuffer>>> kept;
  for (size_t i = 0; i < 500; ++i) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(numbered(i))), GST_FLOW_OK);
    if (i + 1 < kOut) continue;
    kept.emplace_back(i + 1 - kOut, Ref<GstBuffer>::adopt(gst_harness_pull(h.get())));
    while (random() % 3 == 0 && !kept.empty()) {
      auto& one = kept[random() % kept.size()];
      expect_window(one.second.get(), one.first);
      std::swap(one, kept.front());
      kept.pop_front();
    }
  }
  for (auto& [begin, buffer] : kept) expect_window(buffer.get(), begin);
}

// A downstream element that works in place must get its own memory.
TEST(OverlappingWindows, AreNotChangedByDownstreamElements) {
  auto h = make_harness(
      "tensor_aggregator frames-out=2 frames-flush=1 frames-dim=0 ! tensor_transform "
      "mode=arithmetic option=add:1",
      tensors("uint8", "1"));
  for (uint8_t i = 0; i < 20; ++i) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{i})), GST_FLOW_OK);
    if (i == 0) continue;
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(content(out.get()), (Bytes{i, static_cast<uint8_t>(i + 1)}));
  }
}

// The same for frames cut from one buffer.
TEST(OverlappingWindows, PartsAreNotChangedByDownstreamElements) {
  auto h = make_harness(
      "tensor_aggregator frames-in=2 frames-out=1 frames-dim=0 ! tensor_transform "
      "mode=arithmetic option=add:1",
      tensors("uint8", "2"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{5, 7})), GST_FLOW_OK);
  for (const uint8_t value : {6, 8}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), Bytes{value});
  }
}

// Three frames per buffer, windows of five with step two: some windows span buffers.
TEST(OverlappingWindows, SpanBuffersOfSeveralFrames) {
  auto h = make_harness("tensor_aggregator frames-in=3 frames-out=5 frames-flush=2 frames-dim=1",
                        tensors("uint8", "4:3"));
  const Bytes all = ramp(12 * 20);
  for (size_t i = 0; i < 20; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(all.begin() + static_cast<long>(12 * i),
                                                    all.begin() + static_cast<long>(12 * i + 12)))),
              GST_FLOW_OK);
  for (size_t begin = 0; begin + 5 <= 60; begin += 2) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(content(out.get()), Bytes(all.begin() + static_cast<long>(4 * begin),
                                        all.begin() + static_cast<long>(4 * begin + 20)));
  }
}

// One of two tensors can be shared; the other must be interleaved.
TEST(OverlappingWindows, ShareMemoryWherePossible) {
  auto h = make_harness("tensor_aggregator frames-out=2 frames-flush=1 frames-dim=0",
                        tensors("uint8,uint8", "2,1:2"));
  for (uint8_t i = 0; i < 40; ++i) {
    const auto v = static_cast<uint8_t>(4 * i);
    const auto at = [&](int k) { return static_cast<uint8_t>(v + k); };
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{at(0), at(1), at(2), at(3)})), GST_FLOW_OK);
    if (i == 0) continue;
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(content(out.get()),
              (Bytes{at(-4), at(-3), at(0), at(1), at(-2), at(2), at(-1), at(3)}));
  }
}

}  // namespace overlap_test
