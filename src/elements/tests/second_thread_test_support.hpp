// SecondThread: a thread that uses an element while the test changes it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <thread>

#include "becomes.hpp"

namespace weir::test {

// Calls `use` on a separate thread until the object is destroyed.
template <class Use>
class SecondThread {
 public:
  explicit SecondThread(Use use)
      : thread_([this, use] {
          while (!over_) {
            use();
            ++rounds_;
          }
        }) {}
  SecondThread(const SecondThread&) = delete;
  SecondThread& operator=(const SecondThread&) = delete;
  ~SecondThread() {
    EXPECT_TRUE(becomes_true([this] { return rounds_ > 0; }, "the other thread"));
    over_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> over_ = false;
  std::atomic<uint64_t> rounds_ = 0;
  std::thread thread_;
};

}  // namespace weir::test
