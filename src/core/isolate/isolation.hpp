// Isolation: what a user says about a model in a worker process, and what became of it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>
#include <sys/eventfd.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/isolate/confinement.hpp"
#include "core/isolate/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::isolate {

// What follows the end of a worker process.
enum class OnCrash {
  Restart,  // the frame is dropped; so are those that come until a new worker is ready
  Drop,     // the frame is dropped, and every one after it
  Error,    // the frame, and every one after it, is an error
  Wait      // the frame is dropped; those that come wait for the new worker
};
inline bool restarts(OnCrash on_crash) noexcept {
  return on_crash == OnCrash::Restart || on_crash == OnCrash::Wait;
}

struct MonitorCounts {
  uint64_t ended = 0;         // workers that crashed, left, lied, or went beyond their memory
  uint64_t timed_out = 0;     // workers that were ended for their silence
  uint64_t restarted = 0;     // workers that took their place
  uint64_t not_started = 0;   // tries that failed to open the model again
  uint64_t frames_lost = 0;   // dropped because of all that
  uint64_t frames_saved = 0;  // of those, written to a file
  uint64_t bytes_copied = 0;  // between shared and other memory, both ways
};

// Thread-safe. One for each user of isolated models.
class Monitor {
 public:
  // The user wants no answer any more: who waits for a worker, now or later, gets CANCELLED, and
  // the process that was to answer is killed.
  void stop() noexcept { eventfd_write(stop_.get(), 1); }
  bool stopped() const noexcept { return is_readable(stop_.get()); }
  // Readable from stop() on; lives as long as this.
  int stop_descriptor() const noexcept { return stop_.get(); }

  // Is told of each end of a worker, on the thread that noticed it; an empty one ends that.
  void listen(std::function<void(const Error&)> listener) {
    std::lock_guard lock(mutex_);
    listener_ = std::move(listener);
  }
  void tell(const Error& error) const {
    std::unique_lock lock(mutex_);
    const auto listener = listener_;
    lock.unlock();
    if (listener) listener(error);
  }

  MonitorCounts counts() const {
    std::lock_guard lock(mutex_);
    return counts_;
  }
  // As the newest worker reported it.
  Confinement confinement() const {
    std::lock_guard lock(mutex_);
    return confinement_;
  }
  void set_confinement(const Confinement& confinement) {
    std::lock_guard lock(mutex_);
    confinement_ = confinement;
  }
  void add(uint64_t MonitorCounts::*which, uint64_t number = 1) {
    std::lock_guard lock(mutex_);
    counts_.*which += number;
  }

 private:
  static bool is_readable(int descriptor) noexcept {
    pollfd watched{descriptor, POLLIN, 0};
    return poll(&watched, 1, 0) > 0;
  }

  const Descriptor stop_{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  mutable std::mutex mutex_;  // guards the rest
  MonitorCounts counts_;
  Confinement confinement_;
  std::function<void(const Error&)> listener_;
};

struct Isolation {
  std::string engine;                        // a name or alias; "" = found by the model's files
  std::chrono::milliseconds timeout{10000};  // for an invoke; 0 = no limit
  std::chrono::milliseconds least_for_start{60000};  // or ten times the above, if that is more
  uint64_t memory_mib = 0;                           // 0 = no limit
  OnCrash on_crash = OnCrash::Restart;
  std::string crash_folder;  // "" = frames are not kept
  std::string repeat;        // the element with its properties, for the line that repeats a frame
  std::shared_ptr<Monitor> monitor;
  std::vector<std::pair<std::string, std::string>> declared;  // infer::OpenOptions::declared
};

}  // namespace weir::isolate
