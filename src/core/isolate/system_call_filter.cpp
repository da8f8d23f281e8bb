// A seccomp filter: everything is allowed but what would reach out of the process.
#include "core/isolate/system_call_filter.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace weir::isolate {
namespace {

#if defined(__x86_64__)
constexpr uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr uint32_t kMachine = AUDIT_ARCH_AARCH64;
#else
constexpr uint32_t kMachine = 0;
#endif

using Program = std::vector<sock_filter>;

void load(Program* p, size_t offset) {
  p->push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<uint32_t>(offset)));
}
void load_argument(Program* p, size_t index) {  // its lower half
  load(p, offsetof(seccomp_data, args) + index * sizeof(uint64_t));
}
void answer(Program* p, int number) {
  p->push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<uint32_t>(number)));
}
void allow(Program* p) {
  p->push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
}
// The next `steps` are taken only when what is loaded equals, or has one of the bits of, `value`.
void when_equal(Program* p, uint32_t value, uint8_t steps) {
  p->push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, steps));
}
void when_any_bit(Program* p, uint32_t value, uint8_t steps) {
  p->push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, value, 0, steps));
}

Program program() {
  Program p;
  load(&p, offsetof(seccomp_data, arch));
  p.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kMachine, 1, 0));
  answer(&p, ENOSYS);  // calls of another kind of program have other numbers
  load(&p, offsetof(seccomp_data, nr));
#if defined(__x86_64__)
  constexpr uint32_t kX32 = 0x40000000;
  when_any_bit(&p, kX32, 1);
  answer(&p, ENOSYS);
#endif
  // The C library asks for clone3 first, whose flags no filter can see, and takes clone then.
  for (const long call : {SYS_clone3, SYS_io_uring_setup}) {
    when_equal(&p, static_cast<uint32_t>(call), 1);
    answer(&p, ENOSYS);
  }
  for (const long call : {
           SYS_socket,
           SYS_execve,
           SYS_execveat,
           SYS_ptrace,
           SYS_process_vm_readv,
           SYS_process_vm_writev,
           SYS_setns,
           SYS_unshare,
           SYS_mount,
           SYS_umount2,
           SYS_pivot_root,
           SYS_chroot,
           SYS_tkill,
           SYS_rt_sigqueueinfo,
           SYS_rt_tgsigqueueinfo,
           SYS_pidfd_open,
           SYS_pidfd_send_signal,
           SYS_pidfd_getfd,
           SYS_bpf,
           SYS_perf_event_open,
           SYS_userfaultfd,
           SYS_keyctl,
           SYS_add_key,
           SYS_request_key,
           SYS_init_module,
           SYS_finit_module,
           SYS_delete_module,
           SYS_kexec_load,
           SYS_reboot,
#ifdef SYS_fork
           SYS_fork,
           SYS_vfork,
#endif
       }) {
    when_equal(&p, static_cast<uint32_t>(call), 1);
    answer(&p, EPERM);
  }
  // New threads, no new processes.
  when_equal(&p, SYS_clone, 4);
  load_argument(&p, 0);
  when_any_bit(&p, CLONE_THREAD, 1);
  allow(&p);
  answer(&p, EPERM);
  // Signals to itself only; abort() needs that.
  for (const long call : {SYS_kill, SYS_tgkill}) {
    when_equal(&p, static_cast<uint32_t>(call), 4);
    load_argument(&p, 0);
    when_equal(&p, static_cast<uint32_t>(getpid()), 1);
    allow(&p);
    answer(&p, EPERM);
  }
  // It ends with its pipeline.
  when_equal(&p, SYS_prctl, 4);
  load_argument(&p, 0);
  when_equal(&p, PR_SET_PDEATHSIG, 1);
  answer(&p, EPERM);
  allow(&p);
  allow(&p);
  return p;
}

}  // namespace

std::string filter_system_calls() {
  if (kMachine == 0) return "this kind of machine is not known";
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return std::strerror(errno);
  Program steps = program();
  const sock_fprog filter{static_cast<unsigned short>(steps.size()), steps.data()};
  if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0) return std::strerror(errno);
  return "";
}

}  // namespace weir::isolate
