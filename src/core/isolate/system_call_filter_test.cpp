// Tests the filter by interpreting its BPF as the kernel does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/system_call_filter.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/audit.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <future>
#include <set>

#include "refused_calls.hpp"

namespace weir::isolate {
namespace system_call_filter_test {

#if defined(__aarch64__)
constexpr uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#endif
constexpr pid_t kSelf = 4711;
constexpr uint32_t kUnreadable = 0xDEAD;

// The program's result for a call; kUnreadable if it does something that seccomp does not allow.
uint32_t run(const std::vector<sock_filter>& program, const seccomp_data& data) {
  uint32_t a = 0;
  for (size_t at = 0; at < program.size(); ++at) {
    const auto& [code, jt, jf, k] = program[at];
    switch (code) {
      case BPF_LD | BPF_W | BPF_ABS:
        if (k % 4 != 0 || k + 4 > sizeof data) return kUnreadable;
        std::memcpy(&a, reinterpret_cast<const char*>(&data) + k, sizeof a);
        break;
      case BPF_ALU | BPF_AND | BPF_K:
        a &= k;
        break;
      case BPF_JMP | BPF_JEQ | BPF_K:
        at += a == k ? jt : jf;
        break;
      case BPF_JMP | BPF_JGT | BPF_K:
        at += a > k ? jt : jf;
        break;
      case BPF_JMP | BPF_JA:
        at += k;
        break;
      case BPF_RET | BPF_K:
        return k;
      default:
        return kUnreadable;
    }
  }
  return kUnreadable;
}

using Arguments = std::vector<uint64_t>;

// 0: allowed; otherwise the errno for the caller.
int run_filter(const std::vector<sock_filter>& program, long call, const Arguments& arguments = {},
               uint32_t architecture = kArchitecture) {
  seccomp_data data{};
  data.nr = static_cast<int>(call);
  data.arch = architecture;
  for (size_t i = 0; i < arguments.size(); ++i) data.args[i] = arguments[i];
  const uint32_t result = run(program, data);
  if (result == SECCOMP_RET_ALLOW) return 0;
  EXPECT_EQ(result & SECCOMP_RET_ACTION_FULL, uint32_t{SECCOMP_RET_ERRNO}) << result;
  return static_cast<int>(result & SECCOMP_RET_DATA);
}

TEST(CompiledRules, TheFirstMatchingRuleDecides) {
  const std::vector<SystemCallRule> rules{
      {.call = 1},
      {.call = 2, .error = EIO},
      {.call = 3, .error = EIO, .checks = {{{.argument = 0, .mask = 0xFF, .value = 7}}}},
      {.call = 3,
       .checks = {{{.argument = 0, .mask = 0xF, .value = 7},
                   {.argument = 5, .mask = ~uint64_t{0}, .value = 9}}}},
      {.call = 3, .error = ENOTTY, .checks = {{{.argument = 1, .mask = 1, .value = 1}}}},
  };
  const auto program = compile(rules);
  EXPECT_EQ(run_filter(program, 0), EPERM);
  EXPECT_EQ(run_filter(program, 1, {1, 2, 3}), 0);
  EXPECT_EQ(run_filter(program, 2), EIO);
  EXPECT_EQ(run_filter(program, 3, {7, 0, 0, 0, 0, 9}), EIO);
  EXPECT_EQ(run_filter(program, 3, {0x17, 1, 0, 0, 0, 9}), 0);
  EXPECT_EQ(run_filter(program, 3, {0x17, 1, 0, 0, 0, 8}), ENOTTY);
  EXPECT_EQ(run_filter(program, 3, {0x18, 0, 0, 0, 0, 9}), EPERM) << "none holds";
  EXPECT_EQ(run_filter(program, 4), EPERM);
}

TEST(CompiledRules, CompareBothHalvesOfAnArgument) {
  constexpr uint64_t kValue = 0x1234'5678'9ABC'DEF0;
  const std::vector<SystemCallRule> rules{
      {.call = 1, .checks = {{{.argument = 2, .mask = ~uint64_t{0}, .value = kValue}}}},
      {.call = 2, .checks = {{{.argument = 2, .mask = 0xFFFF'FFFF, .value = 5}}}},
      {.call = 3, .checks = {{{.argument = 2, .mask = uint64_t{1} << 40, .value = 0}}}}};
  const auto program = compile(rules);
  EXPECT_EQ(run_filter(program, 1, {0, 0, kValue}), 0);
  for (int bit = 0; bit < 64; ++bit)
    EXPECT_EQ(run_filter(program, 1, {0, 0, kValue ^ uint64_t{1} << bit}), EPERM) << bit;
  EXPECT_EQ(run_filter(program, 2, {0, 0, 5}), 0);
  EXPECT_EQ(run_filter(program, 2, {0, 0, uint64_t{1} << 32 | 5}), 0)
      << "the kernel drops these bits";
  EXPECT_EQ(run_filter(program, 3, {0, 0, ~(uint64_t{1} << 40)}), 0);
  EXPECT_EQ(run_filter(program, 3, {0, 0, uint64_t{1} << 40}), EPERM);
}

TEST(CompiledRules, AllowManyForOneCall) {
  std::vector<SystemCallRule> rules;
  for (uint64_t i = 0; i < 200; ++i)
    rules.push_back({.call = 5, .checks = {{{.argument = 0, .mask = ~uint64_t{0}, .value = i}}}});
  rules.push_back({.call = 6});
  const auto program = compile(rules);
  EXPECT_EQ(run_filter(program, 5, {0}), 0);
  EXPECT_EQ(run_filter(program, 5, {199}), 0);
  EXPECT_EQ(run_filter(program, 5, {200}), EPERM);
  EXPECT_EQ(run_filter(program, 6), 0);
  EXPECT_EQ(run_filter(program, 7), EPERM);
}

class WorkerRules : public ::testing::Test {
 protected:
  void SetUp() override {
    rules_ = worker_rules(kSelf);
    if (rules_.empty()) GTEST_SKIP() << "there is no table for this architecture";
    program_ = compile(rules_);
  }
  int verdict_of(long call, const Arguments& arguments = {}) const {
    return run_filter(program_, call, arguments);
  }
  std::vector<SystemCallRule> rules_;
  std::vector<sock_filter> program_;
};

TEST_F(WorkerRules, FitIntoAFilter) {
  EXPECT_LE(program_.size(), size_t{BPF_MAXINSNS});
  std::set<long> seen;
  for (size_t i = 0; i < rules_.size(); ++i) {
    EXPECT_LE(rules_[i].call, long{kNewestCall});
    if (i > 0 && rules_[i].call == rules_[i - 1].call) continue;
    EXPECT_TRUE(seen.insert(rules_[i].call).second)
        << "the rules of call " << rules_[i].call << " do not stand in a row";
  }
}

TEST_F(WorkerRules, EveryCheckCanHold) {
  for (const auto& rule : rules_)
    for (const auto& check : rule.checks) EXPECT_EQ(check.value & ~check.mask, 0u) << rule.call;
}

TEST_F(WorkerRules, RejectOtherKindsOfProgramsAndNewerCalls) {
  for (const uint32_t other :
       std::initializer_list<uint32_t>{AUDIT_ARCH_I386, AUDIT_ARCH_ARM, AUDIT_ARCH_RISCV64})
    EXPECT_EQ(run_filter(program_, SYS_read, {}, other), ENOSYS) << other;
  EXPECT_EQ(verdict_of(kNewestCall), EPERM);
  EXPECT_EQ(verdict_of(kNewestCall + 1), ENOSYS);
  EXPECT_EQ(verdict_of(-1), ENOSYS);
  constexpr long kX32 = 0x40000000;
  for (const long call : {SYS_read, SYS_kill}) EXPECT_EQ(verdict_of(kX32 | call), ENOSYS) << call;
}

TEST_F(WorkerRules, AllowThreadsAndNoProcesses) {
  constexpr uint64_t kPthread = 0x3D0F00;
  EXPECT_EQ(verdict_of(SYS_clone, {kPthread}), 0);
  EXPECT_EQ(verdict_of(SYS_clone, {0x7D0F00}), 0) << "of musl";
  EXPECT_EQ(verdict_of(SYS_clone, {SIGCHLD}), EPERM);
  for (const uint64_t more : {uint64_t{CLONE_NEWUSER}, uint64_t{CLONE_NEWNS}, uint64_t{CLONE_PIDFD},
                              uint64_t{CLONE_PARENT}, uint64_t{1} << 33, uint64_t{SIGKILL}})
    EXPECT_EQ(verdict_of(SYS_clone, {kPthread | more}), EPERM) << more;
  EXPECT_EQ(verdict_of(SYS_clone, {kPthread & ~uint64_t{CLONE_THREAD}}), EPERM);
  EXPECT_EQ(verdict_of(SYS_clone3), ENOSYS);
}

TEST_F(WorkerRules, NameNoOtherProcess) {
  constexpr uint64_t kOther = 4712, kHigh = uint64_t{1} << 32;
  for (const long call : {SYS_prlimit64, SYS_sched_setaffinity, SYS_sched_setscheduler,
                          SYS_sched_setparam, SYS_move_pages}) {
    EXPECT_EQ(verdict_of(call, {0}), 0) << call;
    EXPECT_EQ(verdict_of(call, {kSelf}), 0) << call;
    EXPECT_EQ(verdict_of(call, {kOther}), EPERM) << call;
    EXPECT_EQ(verdict_of(call, {kHigh | kOther}), EPERM) << call;
  }
  EXPECT_EQ(verdict_of(SYS_sched_setattr, {0}), 0);
  EXPECT_EQ(verdict_of(SYS_sched_setattr, {kSelf}), EPERM)
      << "GLib then does not change its threads";
  for (const long call : {SYS_kill, SYS_tgkill}) {
    EXPECT_EQ(verdict_of(call, {kSelf}), 0);
    for (const uint64_t other : {kOther, uint64_t{0}, ~uint64_t{0}, kHigh, uint64_t(-kSelf)})
      EXPECT_EQ(verdict_of(call, {other}), EPERM) << call << " " << other;
  }
  EXPECT_EQ(verdict_of(SYS_setpriority, {PRIO_PROCESS, 0}), 0);
  EXPECT_EQ(verdict_of(SYS_setpriority, {PRIO_PROCESS, kOther}), EPERM);
  EXPECT_EQ(verdict_of(SYS_setpriority, {PRIO_PGRP, 0}), EPERM);
}

TEST_F(WorkerRules, SetNoOwnerOfADescriptor) {
  for (const uint64_t harmless : {F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_SETLK, F_ADD_SEALS})
    EXPECT_EQ(verdict_of(SYS_fcntl, {3, harmless, 0}), 0) << harmless;
  for (const uint64_t command : {F_SETOWN, F_SETOWN_EX, F_SETSIG, F_NOTIFY, F_SETLEASE, F_GETOWN})
    EXPECT_EQ(verdict_of(SYS_fcntl, {3, command, 0}), EPERM) << command;
  EXPECT_EQ(verdict_of(SYS_fcntl, {3, uint64_t{1} << 32 | F_SETOWN, 0}), EPERM);
  EXPECT_EQ(verdict_of(SYS_fcntl, {3, F_SETFL, O_NONBLOCK | O_APPEND}), 0);
  EXPECT_EQ(verdict_of(SYS_fcntl, {3, F_SETFL, O_NONBLOCK | O_ASYNC}), EPERM);
  for (const uint64_t request : {FIOASYNC, FIOSETOWN, SIOCSPGRP, TIOCSTI, TIOCLINUX, TIOCSPGRP,
                                 TIOCNOTTY, TCSETS, 0x4B48, 0x5606})
    EXPECT_EQ(verdict_of(SYS_ioctl, {0, request}), EPERM) << request;
  EXPECT_EQ(verdict_of(SYS_ioctl, {0, uint64_t{1} << 32 | TIOCSTI}), EPERM);
  constexpr uint64_t kDrmVersion = 0xC0406400, kQueryCapability = 0x80685600;
  for (const uint64_t request :
       {uint64_t{TCGETS}, uint64_t{FIONREAD}, kDrmVersion, kQueryCapability})
    EXPECT_EQ(verdict_of(SYS_ioctl, {0, request}), 0) << request;
}

TEST_F(WorkerRules, GiveNoFileAnotherUsersRights) {
  EXPECT_EQ(verdict_of(SYS_openat, {0, 0, O_RDONLY, 04755}), 0) << "the mode is not used";
  EXPECT_EQ(verdict_of(SYS_openat, {0, 0, O_WRONLY | O_CREAT, 0755}), 0);
  EXPECT_EQ(verdict_of(SYS_openat, {0, 0, O_WRONLY | O_CREAT, 04755}), EPERM);
  EXPECT_EQ(verdict_of(SYS_openat, {0, 0, O_WRONLY | O_TMPFILE, 02755}), EPERM);
  EXPECT_EQ(verdict_of(SYS_openat, {0, 0, O_RDONLY | O_DIRECTORY, 04755}), 0);
  EXPECT_EQ(verdict_of(SYS_fchmodat, {0, 0, 0644}), 0);
  EXPECT_EQ(verdict_of(SYS_fchmodat, {0, 0, 06755}), EPERM);
  EXPECT_EQ(verdict_of(SYS_mknodat, {0, 0, S_IFIFO | 0600}), 0);
  for (const uint64_t type : {S_IFBLK, S_IFCHR, S_IFSOCK})
    EXPECT_EQ(verdict_of(SYS_mknodat, {0, 0, type | 0600}), EPERM);
}

TEST_F(WorkerRules, ConnectNoSocket) {
  EXPECT_EQ(verdict_of(SYS_socketpair, {AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC}), 0);
  EXPECT_EQ(verdict_of(SYS_socketpair, {AF_UNIX, SOCK_DGRAM}), EPERM);
  EXPECT_EQ(verdict_of(SYS_socketpair, {AF_INET, SOCK_STREAM}), EPERM);
  EXPECT_EQ(verdict_of(SYS_getsockopt, {3, SOL_SOCKET, SO_TYPE}), 0);
  EXPECT_EQ(verdict_of(SYS_getsockopt, {3, SOL_SOCKET, SO_PEERCRED}), EPERM);
}

// In a separate process: a thread that is already running tries to create a socket.
int errors_of_a_socket_in_a_filtered_process() {
  std::promise<void> filtered;
  auto error = std::async(std::launch::async, [ready = filtered.get_future()]() mutable {
    ready.wait();
    return socket(AF_UNIX, SOCK_STREAM, 0) < 0 ? errno : 0;
  });
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  const bool done = filter_system_calls().empty();
  filtered.set_value();
  return done ? error.get() : -1;
}

TEST(FilterSystemCalls, HoldsForThreadsThatRunAlready) {
  if (!can_refuse_calls()) GTEST_SKIP() << "this system does not filter system calls";
  if (worker_rules(kSelf).empty()) GTEST_SKIP() << "there is no table for this architecture";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(_exit(errors_of_a_socket_in_a_filtered_process()), testing::ExitedWithCode(EPERM),
              "");
}

}  // namespace system_call_filter_test
}  // namespace weir::isolate
