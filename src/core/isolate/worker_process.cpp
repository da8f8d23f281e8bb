// Starts the process with posix_spawn, which is safe with other threads, and watches and reaps it
// through a pidfd: no signal handler is needed and other children are not affected.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/worker_process.hpp"
#include "machine/environment.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>

extern "C" {  // missing in glibc 2.36
#include <sys/pidfd.h>
}

#include <cerrno>
#include <cstring>

#include "core/config/install_paths.hpp"
#include "core/io/deadline.hpp"
#include "machine/install_command.hpp"

extern char** environ;

namespace weir::isolate {
namespace {

constexpr int kSocketInWorker = 3;

// The arguments of posix_spawn, freed at the end of the scope.
struct SpawnSettings {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  SpawnSettings() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  // The new process inherits only the socket, standard output and standard error.
  int prepare(int socket) {
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    int failed = posix_spawn_file_actions_adddup2(&actions, socket, kSocketInWorker);
    if (!failed) failed = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    if (!failed) failed = posix_spawn_file_actions_addclosefrom_np(&actions, kSocketInWorker + 1);
    if (!failed) failed = posix_spawnattr_setsigmask(&attributes, &none);
    if (!failed) failed = posix_spawnattr_setsigdefault(&attributes, &all);
    if (!failed)
      failed =
          posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    return failed;
  }
};

std::string exit_text(const siginfo_t& info) {
  if (info.si_code == CLD_EXITED) return "exit(" + std::to_string(info.si_status) + ")";
  const char* name = strsignal(info.si_status);
  return "signal " + std::to_string(info.si_status) + " (" + (name ? name : "?") + ")";
}

}  // namespace

std::string worker_fix() {
  return std::string(kInstallWeir) + ", or WEIR_WORKER=/path/to/weir-worker";
}

Error not_started(const std::string& step, int number) {
  return Error{.code = Code::WORKER_NOT_STARTED,
               .what = "the worker process of a model could not be started",
               .offered = step + ": " + std::strerror(number),
               .needed = "the program weir-worker, a free process, free file descriptors",
               .fix = number == EMFILE
                          ? "ulimit -n $(ulimit -Hn), in the shell that starts the program"
                          : worker_fix()};
}

std::string WorkerProcess::program() {
  const char* named = environment_variable("WEIR_WORKER");
  return named && *named ? named : config::kInstalledWorker;
}

Result<std::unique_ptr<WorkerProcess>> WorkerProcess::start(uint64_t memory_mib) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return not_started("socketpair", errno);
  std::unique_ptr<WorkerProcess> worker(new WorkerProcess);
  worker->socket_ = io::Descriptor(ends[0]);
  io::Descriptor theirs(ends[1]);
  if (theirs.get() == kSocketInWorker) {  // dup2 onto itself would keep FD_CLOEXEC
    const int other = fcntl(theirs.get(), F_DUPFD_CLOEXEC, kSocketInWorker + 1);
    if (other < 0) return not_started("fcntl", errno);
    theirs = io::Descriptor(other);
  }
  SpawnSettings settings;
  if (const int failed = settings.prepare(theirs.get())) return not_started("posix_spawn", failed);
  std::string path = program(), parent = std::to_string(getpid()),
              memory = std::to_string(memory_mib);
  char* const arguments[] = {path.data(), parent.data(), memory.data(), nullptr};
  if (const int failed = posix_spawn(&worker->id_, path.c_str(), &settings.actions,
                                     &settings.attributes, arguments, environ))
    return not_started(path, failed);
  worker->process_ = io::Descriptor(pidfd_open(worker->id_, 0));
  if (!worker->process_) {
    const int failed = errno;
    ::kill(worker->id_, SIGKILL);
    waitpid(worker->id_, nullptr, 0);
    return not_started("pidfd_open", failed);
  }
  return worker;
}

void WorkerProcess::kill() noexcept {
  if (process_ && !end_) pidfd_send_signal(process_.get(), SIGKILL, nullptr, 0);
}

std::optional<std::string> WorkerProcess::wait(std::chrono::milliseconds timeout) {
  if (end_) return end_;
  const io::Deadline until = io::deadline_in(timeout);
  pollfd watched{process_.get(), POLLIN, 0};
  int ready = 0;
  do {
    ready = poll(&watched, 1, io::poll_timeout(until));
  } while ((ready < 0 && errno == EINTR) || (ready == 0 && !io::is_over(until)));
  if (ready <= 0) return std::nullopt;
  siginfo_t info{};
  if (waitid(P_PIDFD, static_cast<id_t>(process_.get()), &info, WEXITED) == 0)
    end_ = exit_text(info);
  else  // the application reaps all children, or ignores SIGCHLD
    end_ = "an exit that was not reported to this process";
  return end_;
}

WorkerProcess::~WorkerProcess() {
  constexpr std::chrono::seconds kUntilTheKernelLetsGo{5};
  if (!process_ || end_) return;
  kill();
  wait(kUntilTheKernelLetsGo);
}

}  // namespace weir::isolate
