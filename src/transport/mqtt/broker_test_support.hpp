// TestBroker: a mosquitto of a test on a free port, with files in a folder of its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "becomes.hpp"

extern char** environ;

namespace weir::test {

// A port of 127.0.0.1 on which no process listens.
inline uint16_t free_port() {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  const bool bound = bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
                     getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length) == 0;
  close(fd);
  return bound ? ntohs(address.sin_port) : 0;
}

inline bool accepts_connections(uint16_t port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool out = connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return out;
}

// A port for a process that binds it later: the kernel gives connections and listeners with port 0
// those from 32768 on.
inline uint16_t broker_port() {
  static std::mt19937 random(std::random_device{}());
  uint16_t port = 0;
  do {
    port = static_cast<uint16_t>(20000 + random() % 12000);
  } while (accepts_connections(port));
  return port;
}

// A program of the test; killed at the end.
class Process {
 public:
  explicit Process(std::vector<std::string> line) {
    std::vector<char*> arguments;
    for (auto& argument : line) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;  // a test's reader waits until no process has its output open
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
    if (posix_spawnp(&pid_, arguments[0], &files, nullptr, arguments.data(), environ) != 0)
      pid_ = -1;
    posix_spawn_file_actions_destroy(&files);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() { end(SIGKILL); }
  void end(int signal) {
    if (pid_ <= 0) return;
    kill(pid_, signal);
    wait();
  }
  // The exit status.
  int wait() {
    int status = 0;
    if (pid_ > 0) waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  bool ended() const {
    siginfo_t state{};
    return pid_ <= 0 ||
           (waitid(P_PID, static_cast<id_t>(pid_), &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
            state.si_pid != 0);
  }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
};

class TestBroker {
 public:
  static std::string program() {
    for (const char* path :
         {"/usr/sbin/mosquitto", "/usr/bin/mosquitto", "/usr/local/sbin/mosquitto"})
      if (std::filesystem::exists(path)) return path;
    return "";
  }
  explicit TestBroker(const std::string& settings = "allow_anonymous true\n") {
    char name[] = "/tmp/weir-broker-XXXXXX";
    folder_ = mkdtemp(name);
    // mosquitto cannot choose one itself, and ends where another process took it meanwhile.
    for (int attempts = 20; attempts > 0 && !process_; --attempts) {
      port_ = broker_port();
      std::ofstream(folder_ + "/broker.conf")
          << "listener " << port_ << " 127.0.0.1\nmax_queued_messages 10000\nlog_type none\n"
          << settings;
      if (!launch()) process_.reset();
    }
    EXPECT_TRUE(process_) << "mosquitto does not start";
  }
  TestBroker(const TestBroker&) = delete;
  TestBroker& operator=(const TestBroker&) = delete;
  ~TestBroker() {
    stop();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  void start() { EXPECT_TRUE(launch()) << "mosquitto does not start again"; }
  void stop(int signal = SIGKILL) {
    if (process_) process_->end(signal);
    process_.reset();
  }
  // SIGSTOP freezes it, SIGCONT lets it go on.
  void signal(int number) const { kill(process_->pid(), number); }
  uint16_t port() const { return port_; }
  std::string port_text() const { return std::to_string(port_); }

 private:
  bool launch() {
    process_ = std::make_unique<Process>(
        std::vector<std::string>{program(), "-c", folder_ + "/broker.conf"});
    return becomes_true([this] { return process_->ended() || accepts_connections(port_); },
                        "mosquitto") &&
           !process_->ended();
  }

  std::string folder_;
  uint16_t port_ = 0;
  std::unique_ptr<Process> process_;
};

// Skips the tests of a class where no broker is installed.
class BrokerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (TestBroker::program().empty())
      GTEST_SKIP() << "mosquitto is not installed: apt-get install mosquitto mosquitto-clients";
  }
};

}  // namespace weir::test
