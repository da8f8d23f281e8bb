// Tests when the memory of a frame can be held.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/held_frame.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace weir::infer {
namespace held_frame_test {

struct Owner final : FrameOwner {
  explicit Owner(bool able = true) : able(able) {}
  std::shared_ptr<const void> hold() override { return able ? memory : nullptr; }
  long holders() const { return memory.use_count() - 1; }
  bool able;
  std::shared_ptr<int> memory = std::make_shared<int>(7);
};

int hold(const weir_frame& frame, void (**release)(void*), void** kept) {
  return frame_holder().hold(&frame, release, kept);
}

TEST(HeldFrame, IsHeldUntilItIsReleasedOnAnyThread) {
  weir_frame frame{};
  Owner owner;
  void (*release)(void*) = nullptr;
  void* kept = nullptr;
  {
    const FrameOwnerScope scope(frame, &owner);
    ASSERT_EQ(hold(frame, &release, &kept), WEIR_OK);
  }
  EXPECT_EQ(owner.holders(), 1);
  std::thread([&] { release(kept); }).join();
  EXPECT_EQ(owner.holders(), 0);
}

TEST(HeldFrame, IsRejectedWhereFramesCannotBeHeld) {
  weir_frame frame{}, other{};
  void (*release)(void*) = nullptr;
  void* kept = nullptr;
  EXPECT_LT(hold(frame, &release, &kept), 0) << "no frame is being invoked";
  Owner owner, unable(false);
  {
    const FrameOwnerScope scope(frame, &owner);
    EXPECT_LT(hold(other, &release, &kept), 0) << "another frame is";
    EXPECT_LT(frame_holder().hold(&frame, nullptr, &kept), 0);
    std::thread([&] { EXPECT_LT(hold(frame, &release, &kept), 0) << "on another thread"; }).join();
    {
      const FrameOwnerScope inner(other, &unable);
      EXPECT_LT(hold(other, &release, &kept), 0);
      EXPECT_LT(hold(frame, &release, &kept), 0);
    }
    ASSERT_EQ(hold(frame, &release, &kept), WEIR_OK) << "the outer one again";
    release(kept);
  }
  EXPECT_LT(hold(frame, &release, &kept), 0) << "it has been invoked";
  EXPECT_EQ(owner.holders(), 0);
}

}  // namespace held_frame_test
}  // namespace weir::infer
