// A fork, and what became of it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "trial.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

namespace weir::app {
namespace {

constexpr unsigned kSeconds = 10;
constexpr int kReturned = 42;  // exit() in a module gives others

[[noreturn]] void run(const std::function<void()>& load) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if (const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0)
    dup2(nowhere, STDOUT_FILENO);
  std::signal(SIGALRM, SIG_DFL);
  alarm(kSeconds);
  try {
    load();
  } catch (...) {  // is met again where it can be told
  }
  _exit(kReturned);
}

}  // namespace

// A copy, and not this program started anew: it has what is loaded here, so `load` also meets what
// two libraries do to each other. Threads that libraries have started are not in the copy, but the
// locks they held are. glibc's fork frees those of malloc and stdio; a thread that was just loading
// something, or had a lock of its own library, may make `load` hang or crash. Threads that loading
// has started wait for work, and the alarm ends what hangs: at worst a good module is called bad.
std::string ending_of(const std::function<void()>& load) {
  const pid_t child = fork();
  if (child == 0) run(load);
  if (child < 0) return "";  // cannot be tried; it is done without
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return "";
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM)
    return "it does not return within " + std::to_string(kSeconds) + " seconds";
  if (WIFSIGNALED(status))
    return "it ends the process: signal " + std::to_string(WTERMSIG(status)) + " (" +
           strsignal(WTERMSIG(status)) + ")";
  if (WEXITSTATUS(status) == kReturned) return "";
  return "it ends the process: exit(" + std::to_string(WEXITSTATUS(status)) + ")";
}

}  // namespace weir::app
