// Tests what a module in a worker process can reach, by making the system calls itself. Runs as the
// user of the test and, if that is root, as another user too.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fcntl.h>
#include <linux/futex.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <cerrno>
#include <climits>
#include <cstdio>

#include "core/isolate/isolated_test_support.hpp"

namespace weir::isolate {
namespace reach_test {

// An argument of a system call: a number, or bytes that it points to.
struct Argument {
  Argument(int64_t number) : number(number) {}
  Argument(int number) : number(number) {}
  Argument(const char* path) : bytes(std::string(path) + '\0') {}
  Argument(const std::string& bytes) : bytes(bytes + '\0') {}
  int64_t number = 0;
  std::string bytes;
};
using Arguments = std::vector<Argument>;

struct Outcome {
  int error = 0;
  int value = 0;
};

struct Call {
  const char* name;
  long number;
  Arguments arguments;
};

class Reach : public IsolatedTest {
 protected:
  void SetUp() override {
    IsolatedTest::SetUp();
    const Status status = open();
    ASSERT_TRUE(status) << status.error().message();
    worker_ = static_cast<pid_t>(result_of({kProcess}));
  }

  Outcome call(long number, const Arguments& arguments = {}) {
    constexpr size_t kHead = 64;  // SystemCallOrder of unruly_engine.cpp
    Bytes frame(kHead);
    frame[0] = kSystemCall;
    const auto put = [&frame](size_t at, int64_t value) {
      std::memcpy(frame.data() + at, &value, sizeof value);
    };
    put(8, number);
    for (size_t i = 0; i < arguments.size(); ++i) {
      const auto& argument = arguments[i];
      const bool points = !argument.bytes.empty();
      put(16 + 8 * i, points ? static_cast<int64_t>(frame.size() - kHead) : argument.number);
      if (points) frame[1] |= static_cast<uint8_t>(1 << i);
      frame.insert(frame.end(), argument.bytes.begin(), argument.bytes.end());
    }
    const uint64_t result = result_of(frame);
    constexpr uint64_t kSucceeded = uint64_t{1} << 32;
    if (result >= kSucceeded) return {0, static_cast<int>(result)};
    return {static_cast<int>(result), -1};
  }
  void expect_refused(const std::vector<Call>& calls, int error = EPERM) {
    for (const auto& [name, number, arguments] : calls)
      EXPECT_EQ(call(number, arguments).error, error) << name;
  }
  void expect_allowed(const std::vector<Call>& calls) {
    for (const auto& [name, number, arguments] : calls)
      EXPECT_EQ(call(number, arguments).error, 0) << name;
  }
  int open_error(const std::string& path, int flags = O_RDONLY) {
    return call(SYS_openat, {AT_FDCWD, path, flags, 0}).error;
  }
  std::string refused() const { return isolation_.monitor->confinement().refused; }
  bool files_are_restricted() const { return refused().find("/proc") == std::string::npos; }
  // A field of /proc/WORKER/status.
  std::string status_of_worker(const std::string& name) const {
    std::ifstream file("/proc/" + std::to_string(worker_) + "/status");
    for (std::string line; std::getline(file, line);)
      if (line.starts_with(name + ":\t")) return line.substr(name.size() + 2);
    return "";
  }

  pid_t worker_ = -1;
  const int parent_ = getpid();
  const std::string room_ = std::string(256, '\0');  // written by the kernel
};

// The tests also run as root and must not do damage if a worker is not confined: calls that could
// have other arguments that make the kernel fail with an error other than EPERM.
constexpr int kUnknown = 999, kUnusedId = INT_MAX;

TEST_F(Reach, SendsNoSignal) {
  expect_refused({{"kill", SYS_kill, {parent_, 0}},
                  {"kill all", SYS_kill, {-1, 0}},
                  {"kill the group", SYS_kill, {0, 0}},
                  {"tkill", SYS_tkill, {parent_, 0}},
                  {"tgkill", SYS_tgkill, {parent_, parent_, 0}},
                  {"rt_sigqueueinfo", SYS_rt_sigqueueinfo, {parent_, 0, room_}},
                  {"rt_tgsigqueueinfo", SYS_rt_tgsigqueueinfo, {parent_, parent_, 0, room_}},
                  {"pidfd_open", SYS_pidfd_open, {parent_, 0}},
                  {"pidfd_send_signal", SYS_pidfd_send_signal, {3, 0, 0, 0}},
                  {"mq_notify", SYS_mq_notify, {-1, room_}},
                  {"setpgid", SYS_setpgid, {0, parent_}},
                  {"setsid", SYS_setsid, {}},
                  {"PR_SET_PDEATHSIG", SYS_prctl, {PR_SET_PDEATHSIG, kUnknown}},
                  {"PR_SET_CHILD_SUBREAPER", SYS_prctl, {PR_SET_CHILD_SUBREAPER, 0}}});
}

TEST_F(Reach, SendsNoSignalByADescriptor) {
  expect_refused({{"F_SETOWN", SYS_fcntl, {3, F_SETOWN, parent_}},
                  {"F_SETOWN_EX", SYS_fcntl, {3, F_SETOWN_EX, room_}},
                  {"F_SETSIG", SYS_fcntl, {3, F_SETSIG, kUnknown}},
                  {"O_ASYNC", SYS_fcntl, {0, F_SETFL, O_ASYNC}},
                  {"F_SETLEASE", SYS_fcntl, {0, F_SETLEASE, F_RDLCK}},
                  {"F_NOTIFY", SYS_fcntl, {0, F_NOTIFY, DN_MODIFY}},
                  {"FIOASYNC", SYS_ioctl, {3, int64_t{FIOASYNC}, room_}},
                  {"FIOSETOWN", SYS_ioctl, {3, int64_t{FIOSETOWN}, room_}},
                  {"SIOCSPGRP", SYS_ioctl, {3, int64_t{SIOCSPGRP}, room_}},
                  {"TIOCSPGRP", SYS_ioctl, {0, int64_t{TIOCSPGRP}, room_}},
                  {"TIOCSTI", SYS_ioctl, {0, int64_t{TIOCSTI}, room_}}});
}

// The kernel rejects what the filter cannot check: the thread that a timer signals is in memory.
TEST_F(Reach, SetsNoTimerForAnother) {
  sigevent event{};
  event.sigev_notify = SIGEV_SIGNAL | SIGEV_THREAD_ID;
  event.sigev_signo = SIGALRM;
  event._sigev_un._tid = parent_;
  const std::string bytes(reinterpret_cast<const char*>(&event), sizeof event);
  EXPECT_EQ(call(SYS_timer_create, {CLOCK_MONOTONIC, bytes, room_}).error, EINVAL);
}

TEST_F(Reach, ChangesNoOtherProcess) {
  expect_refused(
      {{"prlimit", SYS_prlimit64, {parent_, kUnknown, room_, 0}},
       {"prlimit, read", SYS_prlimit64, {parent_, RLIMIT_CPU, 0, room_}},
       {"prlimit, high bits", SYS_prlimit64, {int64_t{1} << 32 | parent_, kUnknown, room_, 0}},
       {"sched_setaffinity", SYS_sched_setaffinity, {parent_, 128, room_}},  // no CPU
       {"sched_setscheduler", SYS_sched_setscheduler, {parent_, kUnknown, room_}},
       {"sched_setparam", SYS_sched_setparam, {parent_, 0}},
       {"sched_setattr", SYS_sched_setattr, {parent_, 0, 0}},
       {"setpriority", SYS_setpriority, {PRIO_PROCESS, kUnusedId, 19}},
       {"setpriority of a group", SYS_setpriority, {PRIO_PGRP, kUnusedId, 19}},
       {"setpriority of a user", SYS_setpriority, {PRIO_USER, kUnusedId, 19}},
       {"ioprio_set", SYS_ioprio_set, {1, kUnusedId, 0}},
       {"ioprio_set of a user", SYS_ioprio_set, {3, kUnusedId, 0}},
       {"migrate_pages", SYS_migrate_pages, {parent_, 0, 0, 0}},
       {"move_pages", SYS_move_pages, {parent_, 0, 0, 0, 0, 0}}});
  EXPECT_EQ(result_of({0, 5}), 5u) << "the pipeline lives, and so does the worker";
}

TEST_F(Reach, ReadsNoMemoryOfAnotherProcess) {
  expect_refused({{"ptrace", SYS_ptrace, {PTRACE_PEEKDATA, parent_, 0, 0}},
                  {"process_vm_readv", SYS_process_vm_readv, {parent_, room_, 1, room_, 1, 0}},
                  {"process_vm_writev", SYS_process_vm_writev, {parent_, room_, 1, room_, 1, 0}},
                  {"process_madvise", SYS_process_madvise, {3, room_, 1, MADV_COLD, 0}},
                  {"process_mrelease", SYS_process_mrelease, {3, 0}},
                  {"pidfd_getfd", SYS_pidfd_getfd, {3, 0, 0}},
                  {"kcmp", SYS_kcmp, {parent_, parent_, 0, 0, 0}},
                  {"get_robust_list", SYS_get_robust_list, {parent_, room_, room_}},
                  {"perf_event_open", SYS_perf_event_open, {room_, parent_, -1, -1, -1}},
                  {"bpf", SYS_bpf, {kUnknown, room_, 8}},
                  {"userfaultfd", SYS_userfaultfd, {kUnknown}},
                  {"PR_SET_PTRACER", SYS_prctl, {PR_SET_PTRACER, kUnusedId}},
                  {"PR_SET_DUMPABLE", SYS_prctl, {PR_SET_DUMPABLE, kUnknown}},
                  {"shmget", SYS_shmget, {1, 4096, 0}},
                  {"shmctl", SYS_shmctl, {-1, 0, room_}},
                  {"semctl", SYS_semctl, {-1, 0, 0, 0}},
                  {"msgget", SYS_msgget, {1, 0}},
                  {"mq_open", SYS_mq_open, {"not-there", O_RDWR, 0, 0}},
                  {"keyctl", SYS_keyctl, {kUnknown, 0, 0}},
                  {"add_key", SYS_add_key, {"no type", "weir", room_, 1, -3}},
                  {"request_key", SYS_request_key, {"no type", "weir", 0, -3}}});
}

// Either the user namespace or Landlock is sufficient for these.
TEST_F(Reach, OpensNoMemoryOfAnotherProcess) {
  if (!files_are_restricted() && refused().find("user namespace") != std::string::npos)
    GTEST_SKIP() << refused();
  const std::string folder = "/proc/" + std::to_string(parent_) + "/";
  for (const char* file : {"mem", "environ", "maps", "auxv", "fd/0", "root/etc", "cwd/."})
    EXPECT_EQ(open_error(folder + file), EACCES) << file;
  EXPECT_EQ(open_error(folder + "mem", O_RDWR), EACCES);
}

TEST_F(Reach, OpensNoFileOfAnotherProcess) {
  if (!files_are_restricted()) GTEST_SKIP() << refused();
  const std::string id = std::to_string(parent_);
  for (const std::string& file :
       {"/proc/" + id + "/status", "/proc/" + id + "/cmdline", "/proc/self/../" + id + "/status",
        std::string("/proc/self/") + "root/proc/" + id + "/status",
        "/proc/" + id + "/task/" + id + "/status", std::string("/proc/1/status")})
    EXPECT_EQ(open_error(file), EACCES) << file;
  EXPECT_EQ(open_error("/proc/" + id + "/oom_score_adj", O_WRONLY), EACCES);
  EXPECT_EQ(open_error("/proc/sys/kernel/core_pattern", O_WRONLY), EACCES);
  EXPECT_EQ(open_error("/sys/kernel/uevent_seqnum", O_WRONLY), EACCES);
}

TEST_F(Reach, MountsAndMakesNothing) {
  const char* const path = "/not-there/x";
  expect_refused({{"mount", SYS_mount, {"x", path, "tmpfs", 0, 0}},
                  {"umount2", SYS_umount2, {path, 0}},
                  {"fsopen", SYS_fsopen, {"no type", 0}},
                  {"fsconfig", SYS_fsconfig, {3, kUnknown, 0, 0, 0}},
                  {"fsmount", SYS_fsmount, {3, 0, 0}},
                  {"fspick", SYS_fspick, {AT_FDCWD, path, 0}},
                  {"open_tree", SYS_open_tree, {AT_FDCWD, path, 1}},
                  {"move_mount", SYS_move_mount, {AT_FDCWD, path, AT_FDCWD, path, 0}},
                  {"mount_setattr", SYS_mount_setattr, {AT_FDCWD, path, 0, room_, 32}},
                  {"pivot_root", SYS_pivot_root, {path, path}},
                  {"chroot", SYS_chroot, {path}},
                  {"unshare", SYS_unshare, {1}},
                  {"setns", SYS_setns, {3, 0}},
                  {"swapon", SYS_swapon, {path, 0}},
                  {"swapoff", SYS_swapoff, {path}},
                  {"quotactl", SYS_quotactl, {-1, path, 0, 0}},
                  {"fanotify_init", SYS_fanotify_init, {-1, 0}},
                  {"name_to_handle_at", SYS_name_to_handle_at, {AT_FDCWD, path, room_, room_, 0}},
                  {"open_by_handle_at", SYS_open_by_handle_at, {-1, room_, 0}},
                  {"mknodat", SYS_mknodat, {AT_FDCWD, path, S_IFBLK | 0600, 0}},
                  {"fchmodat", SYS_fchmodat, {AT_FDCWD, path, 04755}},
                  {"openat", SYS_openat, {AT_FDCWD, path, O_CREAT | O_WRONLY, 04755}}});
}

TEST_F(Reach, StartsNoProcess) {
  constexpr int kSharedHandlersOfAProcess = CLONE_SIGHAND | SIGCHLD;  // needs CLONE_VM
  expect_refused({{"execve", SYS_execve, {"/not-there", 0, 0}},
                  {"execveat", SYS_execveat, {AT_FDCWD, "/not-there", 0, 0, 0}},
                  {"clone", SYS_clone, {kSharedHandlersOfAProcess, 0, 0, 0, 0}},
                  {"seccomp", SYS_seccomp, {kUnknown, 0, room_}},
                  {"PR_SET_SECCOMP", SYS_prctl, {PR_SET_SECCOMP, kUnknown}},
                  {"personality", SYS_personality, {ADDR_NO_RANDOMIZE}}});
  EXPECT_EQ(call(SYS_clone3, {room_, 1}).error, ENOSYS);
  EXPECT_EQ(call(SYS_io_uring_setup, {0, room_}).error, ENOSYS);
}

TEST_F(Reach, ConnectsNoSocket) {
  expect_refused({{"socket", SYS_socket, {AF_INET, SOCK_STREAM, 0}},
                  {"socket of Unix", SYS_socket, {AF_UNIX, SOCK_DGRAM, 0}},
                  {"socketpair", SYS_socketpair, {AF_UNIX, SOCK_DGRAM, 0, room_}},
                  {"connect", SYS_connect, {3, room_, 16}},
                  {"bind", SYS_bind, {3, room_, 16}},
                  {"listen", SYS_listen, {3, 1}},
                  {"accept4", SYS_accept4, {3, 0, 0, 0}},
                  {"setsockopt", SYS_setsockopt, {3, SOL_SOCKET, kUnknown, room_, 4}},
                  {"SO_PEERCRED", SYS_getsockopt, {3, SOL_SOCKET, SO_PEERCRED, room_, room_}}});
}

TEST_F(Reach, ChangesNothingOfTheMachineOrItsUser) {
  expect_refused({{"reboot", SYS_reboot, {0, 0, 0, 0}},
                  {"kexec_load", SYS_kexec_load, {0, kUnknown, 0, 0}},
                  {"init_module", SYS_init_module, {0, 0, room_}},
                  {"settimeofday", SYS_settimeofday, {0, 0}},
                  {"clock_settime", SYS_clock_settime, {kUnknown, room_}},
                  {"sethostname", SYS_sethostname, {"x", -1}},
                  {"syslog", SYS_syslog, {kUnknown, room_, 16}},
                  {"acct", SYS_acct, {"/not-there"}},
                  {"setuid", SYS_setuid, {-1}},
                  {"setgroups", SYS_setgroups, {-1, 0}},
                  {"setfsuid", SYS_setfsuid, {-1}},
                  {"capset", SYS_capset, {room_, room_}}});
}

TEST_F(Reach, HasNoCapability) {
  for (const char* set : {"CapInh", "CapPrm", "CapEff", "CapAmb"})
    EXPECT_EQ(status_of_worker(set), "0000000000000000") << set;
  if (refused().find("user namespace") == std::string::npos || geteuid() == 0) {
    EXPECT_EQ(status_of_worker("CapBnd"), "0000000000000000");
  }
  EXPECT_EQ(status_of_worker("NoNewPrivs"), "1");
  EXPECT_EQ(status_of_worker("Seccomp"), "2");
}

TEST_F(Reach, StaysTheSameUser) {
  EXPECT_EQ(call(SYS_getuid).value, static_cast<int>(getuid()));
  EXPECT_EQ(call(SYS_getegid).value, static_cast<int>(getegid()));
}

TEST_F(Reach, CannotRaiseItsMemoryLimit) {
  isolation_.memory_mib = 1000;
  ASSERT_TRUE(open());
  if (isolation_.monitor->confinement().text.find("sanitizer") != std::string::npos)
    GTEST_SKIP() << "no limit with a sanitizer";
  const rlimit max{RLIM_INFINITY, RLIM_INFINITY};
  const std::string bytes(reinterpret_cast<const char*>(&max), sizeof max);
  EXPECT_EQ(call(SYS_prlimit64, {0, RLIMIT_DATA, bytes, 0}).error, EPERM);
  EXPECT_EQ(call(SYS_setrlimit, {RLIMIT_DATA, bytes}).error, EPERM);
}

TEST_F(Reach, StartsThreadsAndGeneratesCode) {
  EXPECT_EQ(result_of({kThreads}), 4u);
  EXPECT_EQ(result_of({kGenerate}), 42u);
}

TEST_F(Reach, ReadsTheFilesOfItsUser) {
  const std::string file = testing::TempDir() + "weir-reach-" + std::to_string(getpid());
  const std::string other = file + "-other", folder = file + "-folder", fifo = file + "-fifo";
  const Outcome made = call(SYS_openat, {AT_FDCWD, file, O_CREAT | O_RDWR | O_TRUNC, 0600});
  ASSERT_EQ(made.error, 0);
  expect_allowed({{"write", SYS_write, {made.value, "weir", 4}},
                  {"ftruncate", SYS_ftruncate, {made.value, 2}},
                  {"fcntl", SYS_fcntl, {made.value, F_SETFL, O_NONBLOCK}},
                  {"flock", SYS_flock, {made.value, 2}},
                  {"close", SYS_close, {made.value}},
                  {"fchmodat", SYS_fchmodat, {AT_FDCWD, file, 0640}},
                  {"renameat2", SYS_renameat2, {AT_FDCWD, file, AT_FDCWD, other, 0}},
                  {"mkdirat", SYS_mkdirat, {AT_FDCWD, folder, 0700}},
                  {"renameat2", SYS_renameat2, {AT_FDCWD, other, AT_FDCWD, folder + "/x", 0}},
                  {"unlinkat", SYS_unlinkat, {AT_FDCWD, folder + "/x", 0}},
                  {"unlinkat", SYS_unlinkat, {AT_FDCWD, folder, AT_REMOVEDIR}},
                  {"mknodat", SYS_mknodat, {AT_FDCWD, fifo, S_IFIFO | 0600, 0}},
                  {"unlinkat", SYS_unlinkat, {AT_FDCWD, fifo, 0}}});
  EXPECT_EQ(open_error("/not-there"), ENOENT);
}

TEST_F(Reach, ReadsTheKernelsFactsAboutItselfAndTheMachine) {
  for (const char* file :
       {"/", "/proc/self/status", "/proc/self/maps", "/proc/self/task", "/proc/thread-self/stat",
        "/proc/mounts", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat",
        "/proc/sys/vm/overcommit_memory", "/sys/devices/system/cpu", "/dev/null", "/dev/urandom",
        "/usr/lib", "/bin/sh"})
    EXPECT_EQ(open_error(file), 0) << file;
  EXPECT_EQ(open_error("/dev/null", O_RDWR), 0);
}

TEST_F(Reach, MakesTheCallsOfEngines) {
  constexpr int kNone = -1;
  expect_allowed(
      {{"mmap",
        SYS_mmap,
        {0, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, kNone, 0}},
       {"memfd_create", SYS_memfd_create, {"weir", 0}},
       {"pipe2", SYS_pipe2, {room_, O_CLOEXEC}},
       {"socketpair", SYS_socketpair, {AF_UNIX, SOCK_STREAM, 0, room_}},
       {"eventfd2", SYS_eventfd2, {0, 0}},
       {"epoll_create1", SYS_epoll_create1, {0}},
       {"timerfd_create", SYS_timerfd_create, {CLOCK_MONOTONIC, 0}},
       {"timer_create", SYS_timer_create, {CLOCK_MONOTONIC, 0, room_}},
       {"inotify_init1", SYS_inotify_init1, {0}},
       {"getrandom", SYS_getrandom, {room_, 16, 0}},
       {"sysinfo", SYS_sysinfo, {room_}},
       {"prlimit64", SYS_prlimit64, {0, RLIMIT_NOFILE, 0, room_}},
       {"prlimit64", SYS_prlimit64, {worker_, RLIMIT_NOFILE, 0, room_}},
       {"sched_getaffinity", SYS_sched_getaffinity, {0, 128, room_}},
       {"sched_yield", SYS_sched_yield, {}},
       {"setpriority", SYS_setpriority, {PRIO_PROCESS, 0, 19}},
       {"kill", SYS_kill, {worker_, 0}},
       {"tgkill", SYS_tgkill, {worker_, worker_, 0}},
       {"membarrier", SYS_membarrier, {0, 0, 0}},
       {"prctl", SYS_prctl, {PR_SET_NAME, "unruly"}},
       {"fcntl", SYS_fcntl, {0, F_DUPFD_CLOEXEC, 3}},
       {"personality", SYS_personality, {int64_t{0xFFFFFFFF}}}});
  EXPECT_EQ(call(SYS_ioctl, {0, int64_t{TCGETS}, room_}).error, ENOTTY) << "asked of /dev/null";
  EXPECT_EQ(call(SYS_futex, {room_, FUTEX_WAKE, 1, 0, 0, 0}).error, 0);
}

// Repeats the tests above in a process of user and group 65534.
TEST(ReachOfAnotherUser, IsTheSame) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become another user";
  constexpr id_t kNobody = 65534;
  constexpr int kNoAccess = 77;
  char program[4096] = {};
  ASSERT_GT(readlink("/proc/self/exe", program, sizeof program - 1), 0);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (syscall(SYS_setgroups, 0, nullptr) != 0 || setresgid(kNobody, kNobody, kNobody) != 0 ||
        setresuid(kNobody, kNobody, kNobody) != 0)
      _exit(1);
    if (access(program, X_OK) != 0) _exit(kNoAccess);
    execl(program, program, "--gtest_filter=Reach.*:Worker.*", "--gtest_brief=1", nullptr);
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoAccess) GTEST_SKIP() << "only root can read the build folder";
  EXPECT_EQ(WEXITSTATUS(status), 0) << "as user 65534: see the failures above";
}

}  // namespace reach_test
}  // namespace weir::isolate
