// The task of a source pad: woken, stopped, restarted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/push_task.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "gstcpp/element/ref.hpp"

namespace push_task_test {

using weir::gst::PushTask;
using weir::gst::Ref;

class PushTaskTest : public ::testing::Test {
 protected:
  void SetUp() override {
    pad_ = Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("src", GST_PAD_SRC))));
    task_.set(pad_.get(), [this] {
      std::unique_lock lock(mutex_);
      ++begun_;
      changed_.notify_all();
      changed_.wait(lock, [this] { return !held_; });
      ++ended_;
      changed_.notify_all();
    });
    start();
  }
  void TearDown() override { stop(); }
  void start() {
    task_.open();
    gst_pad_set_active(pad_.get(), TRUE);
  }
  void stop() {
    task_.close();
    gst_pad_set_active(pad_.get(), FALSE);
    task_.join();
  }
  void wait_for(const int& count, int value) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return count >= value; });
  }
  void hold(bool held) {
    std::lock_guard lock(mutex_);
    held_ = held;
    changed_.notify_all();
  }

  Ref<GstPad> pad_;
  PushTask task_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool held_ = false;
  int begun_ = 0, ended_ = 0;
};

TEST_F(PushTaskTest, EachCallPushesOnceMore) {
  for (int i = 1; i <= 100; ++i) {
    task_.wake();
    wait_for(ended_, i);
  }
  EXPECT_EQ(GST_TASK_STATE(GST_PAD_TASK(pad_.get())), GST_TASK_STARTED);
}

TEST_F(PushTaskTest, ACallDuringAPushIsKept) {
  hold(true);
  task_.wake();
  wait_for(begun_, 1);
  task_.wake();
  task_.wake();
  hold(false);
  wait_for(ended_, 2);
}

TEST_F(PushTaskTest, WithoutACallThereIsNoThread) {
  EXPECT_EQ(GST_PAD_TASK(pad_.get()), nullptr);
}

TEST_F(PushTaskTest, AClosedTaskDoesNothing) {
  task_.wake();
  wait_for(ended_, 1);
  task_.close();
  task_.wake();
  gst_pad_set_active(pad_.get(), FALSE);
  task_.join();
  EXPECT_EQ(begun_, 1);
}

TEST_F(PushTaskTest, EndsOnlyWhenThePushDoes) {
  hold(true);
  task_.wake();
  wait_for(begun_, 1);
  std::atomic<bool> stopped{false};
  std::thread stopping([&] {
    stop();
    stopped = true;
  });
  EXPECT_FALSE(stopped);
  hold(false);
  stopping.join();
  EXPECT_EQ(ended_, 1);
}

TEST_F(PushTaskTest, CanBeRestarted) {
  for (int round = 1; round <= 10; ++round) {
    task_.wake();
    wait_for(ended_, round);
    stop();
    start();
  }
}

}  // namespace push_task_test
