// Isolation: the user's settings for a model in a worker process, and its statistics.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>
#include <sys/eventfd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/isolate/confinement.hpp"
#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::isolate {

// The policy after the end of a worker process.
enum class OnCrash {
  Restart,  // drop the frame and all others until a new worker is ready
  Drop,     // drop the frame and all later ones
  Error,    // fail the frame and all later ones
  Wait      // drop the frame; later ones wait for the new worker
};
inline bool restarts(OnCrash on_crash) noexcept {
  return on_crash == OnCrash::Restart || on_crash == OnCrash::Wait;
}

// The fix of an error that ended a worker.
inline constexpr const char* kRestartAndSave = "on-crash=restart crash-folder=/tmp";

// The result of an invoke whose frame was dropped because no worker ran it to its end. Not a
// weir_no_result, nor a number that an engine would return.
inline constexpr int kFrameLost = 0x5745FFFF;

struct MonitorCounts {
  uint64_t ended = 0;  // workers that crashed, exited, violated the protocol or their memory limit
  uint64_t timed_out = 0;     // workers that were killed after a time-out
  uint64_t restarted = 0;     // replacement workers
  uint64_t not_started = 0;   // failed attempts to reopen the model
  uint64_t frames_lost = 0;   // frames dropped because of that
  uint64_t frames_saved = 0;  // of those, written to a file
  uint64_t bytes_copied = 0;  // between shared and other memory, both ways
};

// Thread-safe. One per user of isolated models.
class Monitor {
 public:
  // Cancels all waits for a worker, now and later, with CANCELLED and kills the process being
  // waited for.
  void stop() noexcept { eventfd_write(stop_.get(), 1); }
  bool stopped() const noexcept { return is_readable(stop_.get()); }
  // Readable after stop(); valid as long as this object. -1 if there was no descriptor for it: then
  // no model opens.
  int stop_descriptor() const noexcept { return stop_.get(); }
  int stop_error() const noexcept { return stop_error_; }  // the errno of that

  // Sets a function called for each end of a worker, on the thread that noticed it; an empty one
  // removes it.
  void listen(std::function<void(const Error&)> listener) {
    std::lock_guard lock(mutex_);
    listener_ = std::move(listener);
  }
  void report(const Error& error) const {
    std::unique_lock lock(mutex_);
    const auto listener = listener_;
    lock.unlock();
    if (listener) listener(error);
  }

  MonitorCounts counts() const {
    std::lock_guard lock(mutex_);
    return counts_;
  }
  // Returns what the newest worker reported.
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

  const io::Descriptor stop_{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  const int stop_error_ = stop_ ? 0 : errno;
  mutable std::mutex mutex_;  // guards the rest
  MonitorCounts counts_;
  Confinement confinement_;
  std::function<void(const Error&)> listener_;
};

struct Isolation {
  std::string engine;                        // name or alias; "" = chosen by the model's files
  std::chrono::milliseconds timeout{10000};  // for an invoke; 0 = no limit
  std::chrono::milliseconds min_for_start{60000};  // or ten times `timeout`, if that is more
  uint64_t memory_mib = 0;                         // 0 = no limit
  OnCrash on_crash = OnCrash::Restart;
  std::string crash_folder;  // "" = do not save frames
  std::string repeat;  // the element with its properties, for the command that replays a frame
  std::shared_ptr<Monitor> monitor;
  std::vector<std::pair<std::string, std::string>> declared;  // infer::OpenOptions::declared
};

}  // namespace weir::isolate
