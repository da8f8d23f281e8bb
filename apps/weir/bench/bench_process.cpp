// Starts this program as `weir bench-case`; the result arrives through a pipe.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "bench/bench_plan.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

#include "report.hpp"

extern char** environ;

namespace weir::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kResult = 3;  // the descriptor in the child process

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const noexcept { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

Error not_started(int number) {
  return {.code = Code::WORKER_NOT_STARTED,
          .what = "the process for a measurement could not be started",
          .offered = strerror(number)};
}

Result<pid_t> start(const BenchCaseOptions& options, int result) {
  std::vector<std::string> words{"weir",
                                 "bench-case",
                                 "--engine=" + options.engine,
                                 "--threads=" + std::to_string(options.threads),
                                 "--batch=" + std::to_string(options.batch),
                                 "--seconds=" + std::to_string(options.seconds),
                                 "--descriptor=" + std::to_string(kResult)};
  if (!options.custom.empty())
    words.push_back("--custom=" + options.custom);  // an empty value is invalid
  for (const auto& [name, value] : options.tensors.pairs())
    words.push_back(std::string("--").append(name).append("=").append(value));
  words.insert(words.end(), {"--", options.model});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const auto& argument : words) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int number : {0, 1, 2})  // the output of engines is not part of the table
    posix_spawn_file_actions_addopen(&actions, number, "/dev/null", number ? O_WRONLY : O_RDONLY,
                                     0);
  posix_spawn_file_actions_adddup2(&actions, result, kResult);
  pid_t process = 0;
  const int failed =
      posix_spawn(&process, "/proc/self/exe", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) return not_started(failed);
  return process;
}

// Reads until the process closes its end; false on a time-out.
bool read_all(int descriptor, Clock::time_point until, std::string* text) {
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd waited{descriptor, POLLIN, 0};
    if (left <= 0 || poll(&waited, 1, static_cast<int>(left)) == 0) return false;
    char block[4096];
    const ssize_t count = read(descriptor, block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    text->append(block, static_cast<size_t>(count));
  }
}

std::string describe_end(int status) {
  if (WIFSIGNALED(status))
    return "signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return "exit code " + std::to_string(WEXITSTATUS(status));
}

Error to_error(const Json& report) {
  const auto text = [&report](const char* name) { return report.value(name, std::string()); };
  return {.code = static_cast<Code>(report.value("code", static_cast<int>(Code::INTERNAL))),
          .what = text("what"),
          .offered = text("offered"),
          .needed = text("needed"),
          .difference = text("difference"),
          .fix = text("fix")};
}

}  // namespace

Result<Measured> run_case(const BenchCaseOptions& options) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return not_started(errno);
  Descriptor reading(ends[0]), writing(ends[1]);
  const auto process = start(options, writing.get());
  if (!process) return process.error();
  writing.close();
  std::string text;
  const auto until =
      Clock::now() +
      std::chrono::milliseconds(static_cast<int64_t>((options.timeout + options.seconds) * 1e3));
  const bool in_time = read_all(reading.get(), until, &text);
  if (!in_time) kill(*process, SIGKILL);
  int status = 0;
  while (waitpid(*process, &status, 0) < 0 && errno == EINTR) continue;
  if (!in_time)
    return Error{
        .code = Code::WORKER_TIMEOUT,
        .what = "a measurement took too long and was stopped",
        .offered =
            "more than " + std::to_string(static_cast<int>(options.timeout)) + " s above its time",
        .fix = "weir bench --timeout " + std::to_string(static_cast<int>(options.timeout * 10))};
  const Json report = Json::parse(text, nullptr, false);
  if (!report.is_object())
    return Error{.code = Code::WORKER_ENDED,
                 .what = "the engine terminated its process",
                 .offered = describe_end(status)};
  if (report.contains("error")) return to_error(report["error"]);
  if (report.value("threads", 0) != options.threads || report.value("batch", 0) != options.batch)
    return Error{.code = Code::INTERNAL,
                 .what = "the process measured a different case than the requested one",
                 .offered = text};
  return Measured{report.value("ms", 0.0),      report.value("low_ms", 0.0),
                  report.value("high_ms", 0.0), report.value("load_ms", 0.0),
                  report.value("mib", 0.0),     report.value("lowering", std::string())};
}

}  // namespace weir::app
