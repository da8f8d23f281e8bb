// A ruleset that allows everything except /proc and /sys, and of these the files that engines read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/landlock.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "core/io/descriptor.hpp"

namespace weir::isolate {
namespace {

// As of ABI 6; the header of Debian 12 has ABI 2.
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

}  // namespace

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

}  // namespace weir::isolate
