// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/forked_load.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

namespace weir::app {
namespace {

constexpr unsigned kTrialSeconds = 10;
constexpr int kReturned = 42;  // differs from the status of an exit() in a module

[[noreturn]] void run(const std::function<void()>& load) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if (const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0)
    dup2(nowhere, STDOUT_FILENO);
  std::signal(SIGALRM, SIG_DFL);
  alarm(kTrialSeconds);
  try {
    load();
  } catch (...) {  // reported when the function runs in this process
  }
  _exit(kReturned);
}

}  // namespace

// Forks instead of starting the program again: the copy has the same libraries loaded, so `load`
// also meets conflicts between two libraries. The threads of libraries are not copied, but the
// locks that they held are. glibc's fork releases those of malloc and stdio; a thread that was
// loading something, or held another library's lock, may make `load` hang or crash. Threads started
// by loading are idle, and the alarm ends hangs: at worst, a usable module is reported as unusable.
std::string failure_of_load(const std::function<void()>& load) {
  const pid_t child = fork();
  if (child == 0) run(load);
  if (child < 0) return "";  // skips the trial
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return "";
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM)
    return "it did not return within " + std::to_string(kTrialSeconds) + " seconds";
  if (WIFSIGNALED(status))
    return "it terminates the process: signal " + std::to_string(WTERMSIG(status)) + " (" +
           strsignal(WTERMSIG(status)) + ")";
  if (WEXITSTATUS(status) == kReturned) return "";
  return "it terminates the process: exit(" + std::to_string(WEXITSTATUS(status)) + ")";
}

}  // namespace weir::app
