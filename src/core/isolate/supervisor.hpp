// Supervisor: keeps one worker available and replaces it when it ends.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "core/isolate/isolation.hpp"
#include "core/isolate/restart_backoff.hpp"
#include "core/isolate/worker.hpp"

namespace weir::isolate {

// Starts and cleans up workers on its own thread, so that streaming threads do not wait for that.
// All functions are called by one thread at a time.
class Supervisor {
 public:
  // Waits for the first worker. Errors: as of Worker::start().
  static Result<std::unique_ptr<Supervisor>> start(WorkerSettings settings, OnCrash on_crash,
                                                   std::shared_ptr<Monitor> monitor);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  // The current worker; null if there is none.
  Worker* ready();
  // Waits for a worker; null if none will follow.
  Worker* wait();
  // Reports that the worker returned by ready() has ended.
  void ended();
  // The model description, common to all its workers.
  const std::shared_ptr<const WorkerModelInfo>& facts() const noexcept { return facts_; }
  // Stores an order for all later workers.
  void remember(int op, const weir_option& option);

 private:
  enum class State { Starting, Ready, Gone };

  Supervisor(WorkerSettings settings, OnCrash on_crash, std::shared_ptr<Monitor> monitor,
             io::Descriptor cancel);
  void run();
  void wait_for_start(std::unique_lock<std::mutex>* lock);
  void start_one();
  Status take_over(Worker* worker);
  void leave(std::unique_ptr<Worker> worker);
  void fail(const Error& error);

  const WorkerSettings settings_;
  const OnCrash on_crash_;
  const std::shared_ptr<Monitor> monitor_;
  const io::Descriptor cancel_;  // an eventfd, readable when this object is destroyed
  std::shared_ptr<const WorkerModelInfo> facts_;  // written before start() returns

  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  State state_ = State::Starting;
  RestartBackoff::Clock::time_point start_at_{};
  RestartBackoff backoff_;
  bool first_ = true, stopping_ = false;
  Error first_error_;
  std::unique_ptr<Worker> worker_, ended_;
  std::vector<std::pair<std::string, std::string>> orders_;  // SET_OPTION, the last of each key
  std::thread thread_;
};

}  // namespace weir::isolate
