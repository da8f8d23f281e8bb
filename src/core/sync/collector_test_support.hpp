// Test helper: a Collector of integers whose consumer records its output.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/sync/collector.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <string>

#include "becomes.hpp"
#include "says.hpp"

namespace weir::sync {

struct Recorder : Consumer<int> {
  int emit(Emission<int> emission) override {
    if (hold) gate.get_future().wait();
    std::lock_guard lock(mutex);
    threads.push_back(std::this_thread::get_id());
    rows.push_back(std::move(emission.frames));
    times.push_back(emission.time);
    return flow;
  }
  void end() override { ended = true; }
  void refused(const Error& error) override {
    if (on_refused) on_refused();
    std::lock_guard lock(mutex);
    errors.push_back(error.message());
  }
  Status may_wait(QueueId, const std::vector<QueueId>&) override {
    if (stalls) return Error{.code = Code::GRAPH_STALLS, .what = "stalls"};
    return ok();
  }
  void waits_for_gap_only_pads(QueueId, const std::vector<QueueId>&) override {}
  bool waits_for_silent_pads(QueueId, const std::vector<QueueId>&) override { return true; }
  size_t count() {
    std::lock_guard lock(mutex);
    return rows.size();
  }

  std::mutex mutex;
  std::vector<std::vector<int>> rows;
  std::vector<Time> times;
  std::vector<std::thread::id> threads;  // the thread that made each row
  std::vector<std::string> errors;
  std::function<void()> on_refused;
  std::promise<void> gate;
  std::atomic<bool> hold{false};
  std::atomic<bool> stalls{false};
  std::atomic<bool> ended{false};
  int flow = kOk;
};

class Collecting : public ::testing::Test {
 protected:
  explicit Collecting() { collector.start(); }
  void use(Mode mode, Clock::duration max_wait = {}) {
    collector.configure({mode, {}, {}}, OnBackwardsTime::Pass, max_wait);
  }
  std::future<int> offer(QueueId queue, int frame, Stamp time) {
    return std::async(std::launch::async,
                      [=, this] { return collector.offer(queue, frame, time); });
  }
  void wait_for_waiting(size_t threads) {
    EXPECT_TRUE(becomes_true([&] { return collector.waiting() == threads; },
                             [&] { return std::to_string(threads) + " waiting threads"; }));
  }
  // A flush whose events downstream accepts at once.
  bool flush_start(QueueId queue) {
    const bool due = collector.flush_start(queue);
    if (due) collector.flush_sent();
    return due;
  }
  bool flush_stop(QueueId queue) {
    const bool due = collector.flush_stop(queue);
    if (due) collector.flush_sent();
    return due;
  }
  uint64_t dropped(DropReason reason) {
    return ledger.snapshot().dropped[static_cast<size_t>(reason)];
  }

  Ledger ledger;
  Recorder out;
  Collector<int> collector{&ledger, &out};
};

}  // namespace weir::sync
