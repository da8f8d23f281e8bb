// Gate: what each invoke of the engine `gated` runs into, and what it saw. One for the process,
// shared by the engine and the tests, which say when a frame goes on: by its first number.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <mutex>
#include <set>
#include <vector>

namespace weir::test {

class __attribute__((visibility("default"))) Gate {
 public:
  static Gate& of_process();

  // As at the start of the process; closed: every frame waits until it is let go.
  void reset(bool open = false);
  void open();
  void let_go(float frame);
  // The frames whose invoke began, in that order, once there are `count`.
  std::vector<float> wait_for_entered(size_t count);
  std::vector<float> entered();

  struct Seen {
    int models = 0, sessions = 0;     // alive
    int most_at_once = 0;             // invokes
    int most_in_a_session = 0;        // invokes
    std::vector<int> threads_wanted;  // of each model that was opened
  };
  Seen seen();

  // For the engine.
  void opened(int threads);
  void closed();
  void session(int by);
  void enter(float frame, int* in_session);

 private:
  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  bool open_ = false;
  std::set<float> let_go_;
  std::vector<float> entered_;
  int at_once_ = 0;
  Seen seen_;
};

}  // namespace weir::test
