// Uses unshare, capset and prctl directly, without libcap.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/privileges.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/securebits.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/io/descriptor.hpp"

namespace weir::isolate {
namespace {

std::string reason_of(bool done) {
  return done ? "" : std::strerror(errno);
}

bool write_file(const char* path, const std::string& text) {
  const io::Descriptor file(open(path, O_WRONLY | O_CLOEXEC));
  return file && write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
}

}  // namespace

Namespaces enter_namespaces() {
  const std::string user = std::to_string(geteuid()), group = std::to_string(getegid());
  Namespaces out;
  out.user = reason_of(unshare(CLONE_NEWUSER) == 0);
  if (out.user.empty()) {
    // Without these, file access is the same but getuid() returns 65534.
    write_file("/proc/self/uid_map", user + " " + user + " 1");
    write_file("/proc/self/setgroups", "deny");
    write_file("/proc/self/gid_map", group + " " + group + " 1");
  }
  out.network = reason_of(unshare(CLONE_NEWNET | CLONE_NEWIPC) == 0 || unshare(CLONE_NEWNET) == 0);
  return out;
}

std::string drop_privileges() {
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return std::strerror(errno);
  // They only matter when another program is executed, which the filter forbids. Without its own
  // namespace a user may not set them.
  constexpr unsigned kBits = SECURE_ALL_BITS & ~issecure_mask(SECURE_KEEP_CAPS);
  prctl(PR_SET_SECUREBITS, kBits | SECURE_ALL_LOCKS, 0, 0, 0);
  prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  for (unsigned long i = 0; prctl(PR_CAPBSET_READ, i, 0, 0, 0) >= 0; ++i)
    prctl(PR_CAPBSET_DROP, i, 0, 0, 0);
  __user_cap_header_struct head{_LINUX_CAPABILITY_VERSION_3, 0};
  const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {};
  if (syscall(SYS_capset, &head, none) != 0) return std::strerror(errno);
  return reason_of(prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) == 0);
}

}  // namespace weir::isolate
