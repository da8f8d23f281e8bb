// What benchmarks of servers share: this program as a server in a process of its own, and the times
// of calls.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "rounds.hpp"
#include "weir/result.hpp"

namespace weir::bench {

using Clock = std::chrono::steady_clock;

inline double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// Ends the program with the error's message.
template <class T>
T value(Result<T> result) {
  if (result) return *std::move(result);
  std::fprintf(stderr, "%s\n", result.error().message().c_str());
  std::exit(1);
}

// This program with other arguments. It prints `port PORT` when it listens, and serves until the
// end of its standard input, or of this program.
class ServerProcess {
 public:
  explicit ServerProcess(std::vector<std::string> arguments) {
    int out[2], in[2];
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(in, O_CLOEXEC) != 0) std::exit(1);
    arguments.insert(arguments.begin(), "/proc/self/exe");
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // also when this program fails
      dup2(in[0], 0);
      dup2(out[1], 1);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(in[0]), close(out[1]);
    input_ = in[1];
    std::string line;
    for (char next = 0; read(out[0], &next, 1) == 1 && next != '\n';) line += next;
    close(out[0]);
    if (line.rfind("port ", 0) != 0) std::exit(1);
    port_ = line.substr(5);
  }
  ~ServerProcess() {
    end();
    close(input_);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;
  const std::string& port() const { return port_; }
  void signal(int number) const { kill(process_, number); }
  void end() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }

 private:
  pid_t process_ = -1;
  int input_ = -1;
  std::string port_;
};

using Call = std::function<void(int thread)>;

// Milliseconds of each call, by all threads.
inline std::vector<double> measure_times(const Call& call, int threads, int calls) {
  std::vector<std::vector<double>> times(static_cast<size_t>(threads));
  const auto work = [&](int thread) {
    for (int i = 0; i < calls; ++i) {
      const auto begin = Clock::now();
      call(thread);
      times[static_cast<size_t>(thread)].push_back(milliseconds_since(begin));
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work, i);
  work(0);
  for (auto& other : others) other.join();
  std::vector<double> all;
  for (const auto& some : times) all.insert(all.end(), some.begin(), some.end());
  return all;
}

// Median microseconds of each of these calls. They have their turns, so that other load affects all
// alike. The first `warm` turns are not counted.
inline std::vector<double> medians_in_turn(const std::vector<Call>& calls, int turns,
                                           int warm = 0) {
  std::vector<std::vector<double>> times(calls.size());
  for (int turn = -warm; turn < turns; ++turn)
    for (size_t which = 0; which < calls.size(); ++which) {
      const double time = 1000 * measure_times(calls[which], 1, 1)[0];
      if (turn >= 0) times[which].push_back(time);
    }
  std::vector<double> out;
  for (const auto& some : times) out.push_back(median(some));
  return out;
}

// Of each candidate, a number of each round.
using Rounds = std::vector<std::vector<double>>;
inline void add_round(const std::vector<double>& numbers, Rounds* rounds) {
  rounds->resize(numbers.size());
  for (size_t i = 0; i < numbers.size(); ++i) (*rounds)[i].push_back(numbers[i]);
}
inline double median_ratio(const std::vector<double>& floor, const std::vector<double>& ours) {
  std::vector<double> ratios;
  for (size_t round = 0; round < ours.size(); ++round) ratios.push_back(ours[round] / floor[round]);
  return median(ratios);
}

// Bytes of the frames that are compared: a small tensor, RGB of 224x224, and RGB in Full HD.
constexpr std::pair<size_t, const char*> kFrameSizes[] = {
    {4096, "4 KiB"}, {150'528, "150 kB"}, {6'220'800, "6 MB"}};

// Calls per second and the 99th percentile of so many threads, for tools/plot: medians of rounds in
// which each series has its turn.
inline void report_clients(const std::vector<std::pair<const char*, Call>>& all, int threads) {
  constexpr int kRounds = 5;
  std::vector<std::vector<double>> rate(all.size()), p99(all.size());
  for (int round = 0; round <= kRounds; ++round)
    for (size_t i = 0; i < all.size(); ++i) {
      const auto begin = Clock::now();
      auto times = measure_times(all[i].second, threads, std::max(20, 1000 / threads));
      const double took = milliseconds_since(begin) / 1000;
      if (round == 0) continue;
      const auto at = times.begin() + static_cast<std::ptrdiff_t>(times.size() * 99 / 100);
      std::nth_element(times.begin(), at, times.end());
      rate[i].push_back(static_cast<double>(times.size()) / took);
      p99[i].push_back(*at);
    }
  for (size_t i = 0; i < all.size(); ++i) {
    std::printf("{\"series\": \"%s\", \"axis\": \"throughput\", \"x\": %d, \"per_s\": %.1f}\n",
                all[i].first, threads, median(rate[i]));
    std::printf("{\"series\": \"%s\", \"axis\": \"p99\", \"x\": %d, \"ms\": %.3f}\n", all[i].first,
                threads, median(p99[i]));
  }
  std::fflush(stdout);
}

}  // namespace weir::bench
