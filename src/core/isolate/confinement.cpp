// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/confinement.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <linux/landlock.h>
#include <linux/securebits.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/isolate/system_call_filter.hpp"
#include "machine/descriptor.hpp"
#include "weir/join.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define WEIR_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define WEIR_SANITIZER 1
#endif
#endif

namespace weir::isolate {
namespace {

// The kernel's reason for refusing each step; "" on success.
struct Namespaces {
  std::string user, network;
};

// The structure of ABI 6; the header of Debian 12 has ABI 2.
struct RulesetAttributes {
  uint64_t handled_access_fs;
  uint64_t handled_access_net;  // ABI 4
  uint64_t scoped;              // ABI 6
};
constexpr uint64_t kTruncate = 1 << 14, kAllNet = 0b11, kAllScopes = 0b11;

constexpr uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr uint64_t kRead = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr uint64_t kFile = kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
// Without executing programs and creating sockets and devices, which are handled but not allowed.
constexpr uint64_t kUse = kRead | kFile | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                          LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_DIR |
                          LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_MAKE_FIFO |
                          LANDLOCK_ACCESS_FS_MAKE_SYM | LANDLOCK_ACCESS_FS_REFER;
constexpr uint64_t kRefuse = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                             LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SOCK;

// The files about the machine that engines and the C library read.
constexpr const char* kOfTheMachine[] = {
    "/proc/bus",     "/proc/cmdline", "/proc/cpuinfo",     "/proc/devices", "/proc/driver",
    "/proc/cgroups", "/proc/loadavg", "/proc/filesystems", "/proc/meminfo", "/proc/modules",
    "/proc/misc",    "/proc/stat",    "/proc/partitions",  "/proc/swaps",   "/proc/sys",
    "/proc/uptime",  "/proc/version", "/proc/pressure",    "/proc/vmstat",  "/proc/zoneinfo"};

class Ruleset {
 public:
  explicit Ruleset(int abi) {
    handled_ = kUse | kRefuse;
    if (abi < 2) handled_ &= ~uint64_t{LANDLOCK_ACCESS_FS_REFER};
    if (abi < 3) handled_ &= ~kTruncate;
    const RulesetAttributes attributes{handled_, abi < 4 ? 0 : kAllNet, abi < 6 ? 0 : kAllScopes};
    descriptor_ = io::Descriptor(
        static_cast<int>(syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0)));
  }
  explicit operator bool() const noexcept { return static_cast<bool>(descriptor_); }

  // `place` is an open path; files support fewer rights than folders. Returns false on failure.
  bool allow(const io::Descriptor& place, uint64_t rights) const {
    struct stat status {};
    if (!place || fstat(place.get(), &status) != 0) return false;
    rights &= S_ISDIR(status.st_mode) ? handled_ : handled_ & kFile;
    const landlock_path_beneath_attr rule{.allowed_access = rights, .parent_fd = place.get()};
    return syscall(SYS_landlock_add_rule, descriptor_.get(), LANDLOCK_RULE_PATH_BENEATH, &rule,
                   0) == 0;
  }
  bool restrict_self() const {
    return syscall(SYS_landlock_restrict_self, descriptor_.get(), 0) == 0;
  }

 private:
  io::Descriptor descriptor_;
  uint64_t handled_ = 0;
};

io::Descriptor open_path(const char* path) {
  return io::Descriptor(open(path, O_PATH | O_CLOEXEC));
}

// No rule for / itself, which would include /proc.
bool allow_all_but_proc_and_sys(const Ruleset& rules) {
  const std::unique_ptr<DIR, int (*)(DIR*)> root(opendir("/"), closedir);
  if (!root || !rules.allow(open_path("/"), LANDLOCK_ACCESS_FS_READ_DIR)) return false;
  while (const dirent* entry = readdir(root.get())) {
    const std::string_view name = entry->d_name;
    if (name == "." || name == ".." || name == "proc" || name == "sys") continue;
    const io::Descriptor place(
        openat(dirfd(root.get()), entry->d_name, O_PATH | O_NOFOLLOW | O_CLOEXEC));
    rules.allow(place, kUse);  // not a link; its target has a rule of its own
  }
  return true;
}

// Keeps the files open, since the kernel may drop an unused inode of /proc together with its rule.
void allow_and_keep_open(const Ruleset& rules, const char* path, uint64_t rights) {
  static std::vector<io::Descriptor> kept;
  kept.push_back(open_path(path));
  rules.allow(kept.back(), rights);
}

std::string get_reason(bool done) {
  return done ? "" : std::strerror(errno);
}

bool write_file(const char* path, const std::string& text) {
  const io::Descriptor file(open(path, O_WRONLY | O_CLOEXEC));
  return file && write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
}

// For a process with one thread and no_new_privs. It keeps access to the files of its user except
// those of other processes in /proc; it can read but not write /sys and the machine's files in
// /proc, lists folders, cannot create files in / itself, and can neither trace nor signal another
// process. Returns "" or the kernel's reason for refusing.
std::string restrict_files() {
  const auto abi =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (abi < 0) return std::strerror(errno);
  const Ruleset rules(static_cast<int>(abi));
  if (!rules || !allow_all_but_proc_and_sys(rules)) return std::strerror(errno);
  rules.allow(open_path("/sys"), kRead);
  for (const char* path : kOfTheMachine) allow_and_keep_open(rules, path, kRead);
  allow_and_keep_open(rules, "/proc/self", kUse);
  return rules.restrict_self() ? "" : std::strerror(errno);
}

// Moves this process, which has one thread, into new user, network and IPC namespaces. It keeps its
// user and group; the namespace has no others.
Namespaces enter_namespaces() {
  const std::string user = std::to_string(geteuid()), group = std::to_string(getegid());
  Namespaces out;
  out.user = get_reason(unshare(CLONE_NEWUSER) == 0);
  if (out.user.empty()) {
    // Without these, file access is the same but getuid() returns 65534.
    write_file("/proc/self/uid_map", user + " " + user + " 1");
    write_file("/proc/self/setgroups", "deny");
    write_file("/proc/self/gid_map", group + " " + group + " 1");
  }
  out.network = get_reason(unshare(CLONE_NEWNET | CLONE_NEWIPC) == 0 || unshare(CLONE_NEWNET) == 0);
  return out;
}

// Permanently drops every capability and prevents tracing and core dumps of this process. Returns
// "" or the kernel's reason for refusing.
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
  return get_reason(prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) == 0);
}

// Writable private memory; shared memory and read-only file mappings do not count.
std::string limit_memory(uint64_t mib) {
  if (mib == 0) return "any memory";
#ifdef WEIR_SANITIZER
  return "any memory (its sanitizer needs more than any limit)";
#else
  const rlimit limit{mib << 20, mib << 20};
  if (setrlimit(RLIMIT_DATA, &limit) != 0)
    return std::string("any memory (") + std::strerror(errno) + ")";
  return "at most " + std::to_string(mib) + " MiB";
#endif
}

class Report {
 public:
  // `refused` is the kernel's reason; "" if the restriction is in effect.
  void add(const std::string& held, const std::string& remains, const std::string& refused) {
    if (refused.empty()) return all_.push_back(held);
    refused_.push_back(remains + " (" + refused + ")");
    all_.push_back(refused_.back());
  }
  Confinement finish(const std::string& memory) {
    all_.push_back(memory);
    return {join(all_, ", "), join(refused_, ", ")};
  }

 private:
  std::vector<std::string> all_, refused_;
};

}  // namespace

// Each step needs rights that later steps remove.
Confinement confine(uint64_t memory_mib) {
  const std::string memory = limit_memory(memory_mib);
  const Namespaces namespaces = enter_namespaces();
  const std::string privileges = drop_privileges();
  const std::string files = restrict_files();
  const std::string calls = filter_system_calls();
  Report report;
  report.add("no new sockets, programs or processes", "new sockets, programs and processes", calls);
  report.add("no network", "the network of this machine", namespaces.network);
  report.add("no capabilities", "the capabilities of the pipeline", privileges);
  report.add("a user namespace of its own", "the user namespace of the pipeline", namespaces.user);
  report.add("no files of other processes in /proc", "files of other processes in /proc", files);
  return report.finish(memory);
}

}  // namespace weir::isolate
