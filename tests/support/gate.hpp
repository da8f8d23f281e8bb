// Gate: blocks each invoke of the engine `gated` and records it. One per process, shared by the
// engine and the tests, which release frames by their first value.
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

  // Resets to the state at process start; closed: every frame waits until it is released.
  void reset(bool open = false);
  void open();
  void let_go(float frame);
  // Waits until `count` invokes have begun and returns their frames in that order.
  std::vector<float> wait_for_entered(size_t count);
  std::vector<float> entered();

  struct Seen {
    int models = 0, sessions = 0;     // currently existing
    int max_at_once = 0;              // concurrent invokes
    int max_in_a_session = 0;         // concurrent invokes
    std::vector<int> threads_wanted;  // per opened model
  };
  Seen seen();

  // Called by the engine.
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
