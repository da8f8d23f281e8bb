// WorkerProcess: starts, watches and reaps a process of the program weir-worker.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/types.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::isolate {

// WORKER_NOT_STARTED: what failed, with its errno.
Error not_started(const std::string& step, int number);
// What brings the worker program where it is missing or another version's.
std::string worker_fix();

class WorkerProcess {
 public:
  // The program: the environment variable WEIR_WORKER, or the installed path.
  static std::string program();

  // The process ends when the calling thread ends. `memory_mib`: limit of private memory; 0 = no
  // limit. WORKER_NOT_STARTED with the reason of the system.
  static Result<std::unique_ptr<WorkerProcess>> start(uint64_t memory_mib);
  // Kills the process if it is running.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  // This end of the socket whose other end is the worker's descriptor 3; call it once.
  io::Descriptor take_socket() noexcept { return std::move(socket_); }
  int descriptor() const noexcept { return process_.get(); }  // a pidfd
  pid_t id() const noexcept { return id_; }

  void kill() noexcept;
  // "signal 11 (Segmentation fault)", "exit(3)"; nullopt: still running after `timeout`.
  std::optional<std::string> wait(std::chrono::milliseconds timeout);

 private:
  WorkerProcess() = default;
  io::Descriptor socket_, process_;
  pid_t id_ = -1;
  std::optional<std::string> end_;
};

}  // namespace weir::isolate
