// Tests asynchronous requests that end on many threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/async_request_test_support.hpp"

#include <atomic>
#include <random>
#include <thread>

#include "becomes.hpp"

namespace weir::infer::async_test {
namespace async_request_threads_test {

// Freeing a session waits for a receiver that is being called.
TEST_F(AsyncRequest, IsNotFreedWhileAReceiverIsCalled) {
  struct Slow final : RequestReceiver {
    std::atomic<bool> entered{false}, leave{false}, left{false};
    void output(weir_frame&) noexcept override {
      entered = true;
      EXPECT_TRUE(becomes_true([&] { return leave.load(); }, "the leave to go on"));
      left = true;
    }
    void end(const Result<int>&) noexcept override {}
  };
  auto session = open();
  const auto slow = std::make_shared<Slow>();
  ASSERT_TRUE(*session->submit(in_, slow));
  Output output(1);
  std::thread engine([&] { complete(submitted[0], &output, true); });
  EXPECT_TRUE(becomes_true([&] { return slow->entered.load(); }, "the call of the receiver"));
  std::thread closer([&] {
    session.reset();
    EXPECT_TRUE(slow->left);
  });
  EXPECT_TRUE(
      becomes_true([&] { return host().cancelled(submitted[0]); }, "the end of the session"));
  slow->leave = true;
  engine.join();
  closer.join();
}

// Threads end requests at random while others begin and are abandoned: each receiver is ended once
// or counted as abandoned.
TEST_F(AsyncRequest, CountsEachRequestOnceUnderThreads) {
  struct Counting final : RequestReceiver {
    explicit Counting(std::atomic<int>* count) : ends(count) {}
    void output(weir_frame&) noexcept override {}
    void end(const Result<int>&) noexcept override { ++*ends; }
    std::atomic<int>* ends;
  };
  max_in_flight = 8;
  std::mutex mutex;  // guards open_requests
  std::vector<weir_request*> open_requests;
  on_submit = [&](weir_request* request, weir_error*) {
    std::lock_guard lock(mutex);
    open_requests.push_back(request);
    return 0;
  };
  std::atomic<int> ends{0};
  std::atomic<bool> done{false};
  int begun = 0;
  size_t abandoned = 0;
  auto session = open();
  std::vector<std::thread> engine;
  for (unsigned seed = 0; seed < 3; ++seed)
    engine.emplace_back([&, random = std::mt19937(seed)]() mutable {
      while (!done) {
        weir_request* request = nullptr;
        {
          std::lock_guard lock(mutex);
          if (!open_requests.empty()) {
            const auto at = open_requests.begin() +
                            static_cast<std::ptrdiff_t>(random() % open_requests.size());
            request = *at;
            open_requests.erase(at);
          }
        }
        if (!request) {
          std::this_thread::yield();
          continue;
        }
        Output output(1);
        complete(request, &output, true);
        complete(request, nullptr, false);
      }
    });
  for (int i = 0; i < 2000; ++i) {
    if (!session->requests().wait_for_room()) break;
    begun += *session->submit(in_, std::make_shared<Counting>(&ends)) ? 1 : 0;
    if (i % 50 != 49) continue;
    abandoned += session->abandon();
    session->requests().resume();
  }
  EXPECT_TRUE(session->requests().wait_until_idle());
  done = true;
  for (auto& thread : engine) thread.join();
  EXPECT_EQ(begun, 2000);
  EXPECT_EQ(static_cast<size_t>(ends) + abandoned, 2000u);
}

}  // namespace async_request_threads_test
}  // namespace weir::infer::async_test
