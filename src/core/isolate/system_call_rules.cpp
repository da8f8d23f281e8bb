// The table: first the calls that are always allowed, then those that depend on their arguments.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/system_call_rules.hpp"

#include <fcntl.h>
#include <linux/ioprio.h>
#include <linux/prctl.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <cerrno>
#include <initializer_list>

#if defined(__x86_64__) || defined(__aarch64__)

namespace weir::isolate {
namespace {

// Newer than the headers of Debian 12. Since Linux 5.1 a call has one number on all architectures.
constexpr long kFchmodat2 = 452, kMapShadowStack = 453, kFutexWake = 454, kFutexWait = 455,
               kFutexRequeue = 456, kMseal = 462;

// clang-format off
constexpr long kAllowed[] = {
    // Calls of every frame; first, because the filter compares in this order.
    SYS_futex, SYS_sched_yield, SYS_recvmsg, SYS_sendmsg, SYS_ppoll, SYS_read, SYS_write,
    SYS_madvise, SYS_mmap, SYS_munmap, SYS_mprotect, SYS_brk,
    // Memory of this process.
    SYS_get_mempolicy, SYS_mbind, SYS_membarrier, SYS_memfd_create, SYS_mincore, SYS_mlock,
    SYS_mlock2, SYS_mlockall, SYS_mremap, SYS_msync, SYS_munlock, SYS_munlockall, SYS_pkey_alloc,
    SYS_pkey_free, SYS_pkey_mprotect, SYS_set_mempolicy, kMapShadowStack, kMseal,
    // Threads, time, signals. The kernel delivers a timer's signal to the caller's threads only.
    SYS_clock_getres, SYS_clock_gettime, SYS_clock_nanosleep, SYS_exit, SYS_exit_group,
    SYS_futex_waitv, SYS_getcpu, SYS_getitimer, SYS_gettid, SYS_gettimeofday, SYS_nanosleep,
    SYS_restart_syscall, SYS_rseq, SYS_rt_sigaction, SYS_rt_sigpending, SYS_rt_sigprocmask,
    SYS_rt_sigreturn, SYS_rt_sigsuspend, SYS_rt_sigtimedwait, SYS_set_robust_list,
    SYS_set_tid_address, SYS_setitimer, SYS_sigaltstack, SYS_timer_create, SYS_timer_delete,
    SYS_timer_getoverrun, SYS_timer_gettime, SYS_timer_settime, SYS_timerfd_create,
    SYS_timerfd_gettime, SYS_timerfd_settime, kFutexRequeue, kFutexWait, kFutexWake,
    // Queries.
    SYS_capget, SYS_getegid, SYS_geteuid, SYS_getgid, SYS_getgroups, SYS_getpgid, SYS_getpid,
    SYS_getppid, SYS_getpriority, SYS_getrandom, SYS_getresgid, SYS_getresuid, SYS_getrlimit,
    SYS_getrusage, SYS_getsid, SYS_getuid, SYS_ioprio_get, SYS_sched_get_priority_max,
    SYS_sched_get_priority_min, SYS_sched_getaffinity, SYS_sched_getattr, SYS_sched_getparam,
    SYS_sched_getscheduler, SYS_sched_rr_get_interval, SYS_sysinfo, SYS_times, SYS_uname,
    // This process only: it has no children.
    SYS_setrlimit, SYS_umask, SYS_wait4, SYS_waitid,
    // Open descriptors.
    SYS_close, SYS_close_range, SYS_copy_file_range, SYS_dup, SYS_dup3, SYS_epoll_create1,
    SYS_epoll_ctl, SYS_epoll_pwait, SYS_epoll_pwait2, SYS_eventfd2, SYS_fadvise64, SYS_fallocate,
    SYS_fdatasync, SYS_flock, SYS_fstat, SYS_fstatfs, SYS_fsync, SYS_ftruncate,
    SYS_inotify_add_watch, SYS_inotify_init1, SYS_inotify_rm_watch, SYS_lseek, SYS_pipe2,
    SYS_pread64, SYS_preadv, SYS_preadv2, SYS_pselect6, SYS_pwrite64, SYS_pwritev, SYS_pwritev2,
    SYS_readahead, SYS_readv, SYS_sendfile, SYS_signalfd4, SYS_splice, SYS_sync,
    SYS_sync_file_range, SYS_syncfs, SYS_tee, SYS_writev,
    // The files of the user.
    SYS_chdir, SYS_faccessat, SYS_faccessat2, SYS_fchdir, SYS_fchown, SYS_fchownat, SYS_fgetxattr,
    SYS_flistxattr, SYS_fremovexattr, SYS_fsetxattr, SYS_getcwd, SYS_getdents64, SYS_getxattr,
    SYS_lgetxattr, SYS_linkat, SYS_listxattr, SYS_llistxattr, SYS_lremovexattr, SYS_lsetxattr,
    SYS_mkdirat, SYS_newfstatat, SYS_readlinkat, SYS_removexattr, SYS_renameat, SYS_renameat2,
    SYS_setxattr, SYS_statfs, SYS_statx, SYS_symlinkat, SYS_truncate, SYS_unlinkat, SYS_utimensat,
    // Existing sockets: the pipeline's, and pairs within the process.
    SYS_getpeername, SYS_getsockname, SYS_recvfrom, SYS_sendto, SYS_shutdown,
#if defined(__x86_64__)
    // Older forms of the above, missing on newer architectures.
    SYS_access, SYS_alarm, SYS_arch_prctl, SYS_chown, SYS_dup2, SYS_epoll_create, SYS_epoll_wait,
    SYS_eventfd, SYS_futimesat, SYS_getdents, SYS_getpgrp, SYS_inotify_init, SYS_lchown, SYS_link,
    SYS_lstat, SYS_mkdir, SYS_pause, SYS_pipe, SYS_poll, SYS_readlink, SYS_rename, SYS_rmdir,
    SYS_select, SYS_signalfd, SYS_stat, SYS_symlink, SYS_time, SYS_unlink, SYS_utime, SYS_utimes,
#endif
};
// clang-format on

constexpr uint64_t kInt = 0xFFFFFFFF;

constexpr ArgumentCheck equals(uint8_t argument, uint32_t value) {
  return {.argument = argument, .mask = kInt, .value = value};
}
constexpr ArgumentCheck lacks(uint8_t argument, uint32_t bits) {
  return {.argument = argument, .mask = bits, .value = 0};
}

using Rules = std::vector<SystemCallRule>;

void allow(Rules* rules, long call, ArgumentCheck first, ArgumentCheck second = {}) {
  rules->push_back({.call = call, .error = 0, .checks = {first, second}});
}
void allow_values(Rules* rules, long call, uint8_t argument,
                  std::initializer_list<uint32_t> values) {
  for (const uint32_t value : values) allow(rules, call, equals(argument, value));
}
void refuse(Rules* rules, long call, int error, ArgumentCheck check = {}) {
  rules->push_back({.call = call, .error = error, .checks = {check}});
}

// The C library has a fallback for these. Their arguments are in memory, which a filter cannot
// read.
void add_absent(Rules* rules) {
  for (const long call : {SYS_clone3, SYS_io_uring_setup, SYS_openat2}) refuse(rules, call, ENOSYS);
}

// Threads with the flags of pthread_create(), but no processes.
void add_threads(Rules* rules) {
  constexpr uint32_t kDetached = 0x400000;  // from old C libraries; the kernel ignores it
  constexpr uint32_t kThread = CLONE_VM | CLONE_SIGHAND | CLONE_THREAD;
  constexpr uint32_t kOfThreads = kThread | CLONE_FS | CLONE_FILES | CLONE_SYSVSEM | CLONE_SETTLS |
                                  CLONE_PARENT_SETTID | CLONE_CHILD_CLEARTID | kDetached;
  allow(rules, SYS_clone, {.argument = 0, .mask = kThread, .value = kThread},
        {.argument = 0, .mask = ~uint64_t{kOfThreads}, .value = 0});
}

// Calls on a process or a thread: this process, or (0) the calling thread. A filter cannot
// distinguish other threads of this process from other processes.
void add_processes(Rules* rules, uint32_t self) {
  for (const long call : {SYS_kill, SYS_tgkill}) allow(rules, call, equals(0, self));
  for (const long call : {SYS_migrate_pages, SYS_move_pages, SYS_prlimit64, SYS_sched_setaffinity,
                          SYS_sched_setparam, SYS_sched_setscheduler})
    allow_values(rules, call, 0, {0, self});
  // GLib tries this with the ID of its main thread and, if it succeeds, expects it to succeed for
  // all threads.
  allow_values(rules, SYS_sched_setattr, 0, {0});
  for (const uint32_t who : {uint32_t{0}, self})
    allow(rules, SYS_setpriority, equals(0, PRIO_PROCESS), equals(1, who));
  for (const uint32_t who : {uint32_t{0}, self})
    allow(rules, SYS_ioprio_set, equals(0, IOPRIO_WHO_PROCESS), equals(1, who));
  allow(rules, SYS_personality, equals(0, 0xFFFFFFFF));  // query
}

// No set-user-ID or set-group-ID bits: such a file would run with the user's rights for others.
void add_modes(Rules* rules) {
  constexpr uint32_t kSetId = S_ISUID | S_ISGID, kCreates = O_CREAT | (O_TMPFILE & ~O_DIRECTORY);
  const auto add_open = [&](long call, uint8_t flags) {
    allow(rules, call, lacks(flags, kCreates));
    allow(rules, call, lacks(static_cast<uint8_t>(flags + 1), kSetId));
  };
  const auto add_mode = [&](long call, uint8_t mode) { allow(rules, call, lacks(mode, kSetId)); };
  const auto add_fifo = [&](long call, uint8_t mode) {
    allow(rules, call, {.argument = mode, .mask = S_IFMT | kSetId, .value = S_IFIFO});
  };
  add_open(SYS_openat, 2);
  add_mode(SYS_fchmod, 1);
  add_mode(SYS_fchmodat, 2);
  add_mode(kFchmodat2, 2);
  add_fifo(SYS_mknodat, 2);
#if defined(__x86_64__)
  add_open(SYS_open, 1);
  add_mode(SYS_creat, 1);
  add_mode(SYS_chmod, 1);
  add_fifo(SYS_mknod, 1);
#endif
}

// No commands by which a descriptor signals an owner (F_SETOWN, F_SETSIG, F_NOTIFY, O_ASYNC).
void add_descriptors(Rules* rules) {
  constexpr uint32_t kDupfdQuery = 1027;
  allow_values(rules, SYS_fcntl, 1,
               {F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_GETLK, F_SETLK, F_SETLKW, F_OFD_GETLK,
                F_OFD_SETLK, F_OFD_SETLKW, F_DUPFD_CLOEXEC, F_SETPIPE_SZ, F_GETPIPE_SZ, F_ADD_SEALS,
                F_GET_SEALS, kDupfdQuery});
  allow(rules, SYS_fcntl, equals(1, F_SETFL), lacks(2, O_ASYNC));
}

// Allows device ioctls (GPUs, accelerators, cameras) but few of terminals and sockets: no simulated
// input, no signal to an owner, no console keyboard.
void add_device_controls(Rules* rules) {
  constexpr uint32_t kType = 0xFF00, kConsole = 0xFFFFFF00, kTcgets2 = 0x802C542A;
  allow_values(rules, SYS_ioctl, 1,
               {TCGETS, kTcgets2, TIOCGWINSZ, FIONREAD, FIONBIO, FIOCLEX, FIONCLEX});
  for (const uint32_t type : {'T' << 8, 0x89 << 8})
    refuse(rules, SYS_ioctl, EPERM, {.argument = 1, .mask = kType, .value = type});
  for (const uint32_t type : {'K' << 8, 'V' << 8})
    refuse(rules, SYS_ioctl, EPERM, {.argument = 1, .mask = kConsole, .value = type});
  allow(rules, SYS_ioctl, {});
}

void add_sockets(Rules* rules) {
  // Stream sockets only: a pair of datagram sockets can send to the path of another socket.
  allow(rules, SYS_socketpair, equals(0, AF_UNIX),
        {.argument = 1,
         .mask = kInt & ~uint64_t{SOCK_CLOEXEC | SOCK_NONBLOCK},
         .value = SOCK_STREAM});
  for (const uint32_t option : {SO_TYPE, SO_ERROR, SO_DOMAIN, SO_PROTOCOL})
    allow(rules, SYS_getsockopt, equals(1, SOL_SOCKET), equals(2, option));
}

void add_prctl(Rules* rules) {
  allow_values(rules, SYS_prctl, 0,
               {PR_SET_NAME,
                PR_GET_NAME,
                PR_GET_DUMPABLE,
                PR_GET_PDEATHSIG,
                PR_SET_TIMERSLACK,
                PR_GET_TIMERSLACK,
                PR_CAPBSET_READ,
                PR_GET_SECCOMP,
                PR_GET_SECUREBITS,
                PR_GET_NO_NEW_PRIVS,
                PR_SET_NO_NEW_PRIVS,
                PR_SET_THP_DISABLE,
                PR_GET_THP_DISABLE,
                PR_GET_SPECULATION_CTRL,
                PR_GET_TSC,
                PR_SET_VMA,
                PR_SVE_SET_VL,
                PR_SVE_GET_VL,
                PR_SME_SET_VL,
                PR_SME_GET_VL,
                PR_PAC_RESET_KEYS,
                PR_SET_TAGGED_ADDR_CTRL,
                PR_GET_TAGGED_ADDR_CTRL});
}

}  // namespace

std::vector<SystemCallRule> worker_rules(pid_t self) {
  Rules rules;
  for (const long call : kAllowed) allow(&rules, call, {});
  add_absent(&rules);
  add_threads(&rules);
  add_processes(&rules, static_cast<uint32_t>(self));
  add_modes(&rules);
  add_descriptors(&rules);
  add_device_controls(&rules);
  add_sockets(&rules);
  add_prctl(&rules);
  return rules;
}

}  // namespace weir::isolate

#else

namespace weir::isolate {
std::vector<SystemCallRule> worker_rules(pid_t) {
  return {};
}
}  // namespace weir::isolate

#endif
