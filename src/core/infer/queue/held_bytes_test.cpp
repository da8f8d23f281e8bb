// Tests the common limit of frames in progress and results waiting to leave.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/held_bytes.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <functional>
#include <thread>

#include "becomes.hpp"

namespace weir::infer {
namespace held_bytes_test {

using FrameAdmission = HeldBytes::FrameAdmission;
using Room = HeldBytes::Room;
using Share = HeldBytes::Share;

constexpr char kResult[] = "a result that waits";

// A queue whose results the test controls.
struct Queue final : HeldBytes::Results {
  std::atomic<bool> others_leave{true}, next{false};
  std::deque<uint64_t> waiting;
  std::function<void()> requested = [] {};
  bool leave() const override {
    requested();
    return others_leave;
  }
  bool is_next() const override { return next; }
  std::optional<uint64_t> drop_oldest() override {
    if (waiting.empty()) return std::nullopt;
    const uint64_t oldest = waiting.front();
    waiting.pop_front();
    return oldest;
  }
};

std::shared_ptr<HeldBytes> bound(uint64_t bytes, WhenBusy when_busy = WhenBusy::Block) {
  return std::make_shared<HeldBytes>(bytes, when_busy);
}
FrameAdmission frame(const std::shared_ptr<HeldBytes>& held, uint64_t bytes, Share* share) {
  return HeldBytes::try_frame(held, bytes, share);
}

TEST(HeldBytes, CountsWithoutABound) {
  const auto held = bound(0);
  Queue queue;
  {
    Share a, b;
    EXPECT_EQ(frame(held, 100, &a), FrameAdmission::Taken);
    EXPECT_EQ(frame(held, 50, &b), FrameAdmission::Taken);
    EXPECT_EQ(held->take_result(7, queue), Room::Taken);
    EXPECT_EQ(held->state().held, 157u);
  }
  EXPECT_EQ(held->state().held, 7u) << "frames that ended";
  held->release_result(7);
  EXPECT_EQ(held->state().held, 0u);
  EXPECT_EQ(held->state().peak, 157u);
}

TEST(HeldBytes, HasOneBoundForFramesAndResults) {
  const auto held = bound(100, WhenBusy::DropNew);
  Queue queue;
  Share a, b;
  EXPECT_EQ(frame(held, 60, &a), FrameAdmission::Taken);
  EXPECT_EQ(held->take_result(30, queue), Room::Taken);
  EXPECT_EQ(frame(held, 11, &b), FrameAdmission::Full);
  EXPECT_EQ(held->take_result(11, queue), Room::Dropped);
  EXPECT_EQ(held->take_result(10, queue), Room::Taken) << "to the last byte";
  EXPECT_EQ(held->state().peak, 100u);
  EXPECT_EQ(held->state().dropped, 1u);
}

TEST(HeldBytes, AcceptsASingleFrameOfAnySize) {
  for (const auto when_busy : {WhenBusy::Block, WhenBusy::DropNew, WhenBusy::DropOld}) {
    const auto held = bound(1, when_busy);
    Queue queue;
    Share a, b;
    EXPECT_EQ(HeldBytes::take_frame(held, 50, &a), FrameAdmission::Taken);
    EXPECT_EQ(frame(held, 1, &b), FrameAdmission::Full);
    EXPECT_EQ(held->take_result(50, queue), Room::Taken) << "the first result waits for none";
    queue.others_leave = false, queue.next = true;
    EXPECT_EQ(held->take_result(50, queue), Room::Taken) << "leaves at once";
  }
}

TEST(HeldBytes, WaitsUntilResultsHaveLeft) {
  const auto held = bound(20);
  Queue queue;
  std::atomic<int> requested{0};
  queue.requested = [&] { ++requested; };
  EXPECT_EQ(held->take_result(20, queue), Room::Taken);
  std::thread engine([&] { EXPECT_EQ(held->take_result(15, queue), Room::Taken); });
  EXPECT_TRUE(becomes_true([&] { return held->state().result_waits; }, kResult));
  held->release_result(14);
  EXPECT_TRUE(becomes_true([&] { return requested >= 2 && held->state().result_waits; }, kResult));
  EXPECT_EQ(held->state().held, 6u) << "a byte is missing";
  held->release_result(1);
  engine.join();
  EXPECT_EQ(held->state().held, 20u);
  EXPECT_EQ(held->state().peak, 20u);
}

TEST(HeldBytes, ReportsWhenOnlyTheEngineCanMakeRoom) {
  const auto held = bound(20);
  Queue queue;
  EXPECT_EQ(held->take_result(20, queue), Room::Taken);
  queue.others_leave = false;
  EXPECT_EQ(held->take_result(1, queue), Room::Stuck) << "of a frame after an older one";
  queue.others_leave = true;
  std::thread engine([&] { EXPECT_EQ(held->take_result(1, queue), Room::Stuck); });
  EXPECT_TRUE(becomes_true([&] { return held->state().result_waits; }, kResult));
  queue.others_leave = false;
  held->moved();
  engine.join();
}

TEST(HeldBytes, DropsTheOldestThatWaits) {
  const auto held = bound(30, WhenBusy::DropOld);
  Queue queue;
  for (const uint64_t bytes : {10, 10, 10}) EXPECT_EQ(held->take_result(bytes, queue), Room::Taken);
  queue.waiting = {10, 10};  // one is being dispatched
  EXPECT_EQ(held->take_result(15, queue), Room::Taken) << "in the place of two";
  EXPECT_EQ(held->state().held, 25u);
  EXPECT_EQ(held->take_result(15, queue), Room::Dropped) << "none waits";
  EXPECT_EQ(held->state().dropped, 3u);
}

TEST(HeldBytes, AFlushWakesWaitingCallers) {
  const auto held = bound(10);
  Queue queue;
  Share a, b, c;
  EXPECT_EQ(frame(held, 5, &a), FrameAdmission::Taken);
  EXPECT_EQ(held->take_result(5, queue), Room::Taken);
  std::thread brings(
      [&] { EXPECT_EQ(HeldBytes::take_frame(held, 1, &b), FrameAdmission::Refused); });
  std::thread engine([&] { EXPECT_EQ(held->take_result(1, queue), Room::Refused); });
  EXPECT_TRUE(becomes_true([&] { return held->state().frame_waits && held->state().result_waits; },
                           "a frame and a result that wait"));
  held->refuse();
  brings.join();
  engine.join();
  EXPECT_EQ(frame(held, 1, &c), FrameAdmission::Refused);
  held->resume();
  held->release_result(5);
  EXPECT_EQ(frame(held, 5, &c), FrameAdmission::Taken);
  EXPECT_EQ(held->state().held, 10u) << "the frame from before is still in work";
}

TEST(HeldBytes, RejectsOnlyFramesAfterAFailure) {
  const auto held = bound(10);
  Queue queue;
  Share a;
  held->refuse_frames();
  EXPECT_EQ(HeldBytes::take_frame(held, 1, &a), FrameAdmission::Refused);
  EXPECT_EQ(held->take_result(1, queue), Room::Taken);
}

}  // namespace held_bytes_test
}  // namespace weir::infer
