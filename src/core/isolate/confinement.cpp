// Limits first, what forbids setting them last.
#include "core/isolate/confinement.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/isolate/descriptor.hpp"
#include "core/isolate/system_call_filter.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define WEIR_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define WEIR_SANITIZER 1
#endif
#endif

namespace weir::isolate {
namespace {

// Private memory that can be written; what is shared and what is read from files does not count.
std::string limit_memory(uint64_t mib) {
  if (mib == 0) return "any memory";
#ifdef WEIR_SANITIZER
  return "any memory (its sanitizer takes more than any limit)";
#else
  const rlimit limit{mib << 20, mib << 20};
  if (setrlimit(RLIMIT_DATA, &limit) != 0)
    return std::string("any memory (") + std::strerror(errno) + ")";
  return "at most " + std::to_string(mib) + " MiB";
#endif
}

void write_file(const char* path, const std::string& text) {
  const Descriptor file(open(path, O_WRONLY | O_CLOEXEC));
  if (file && write(file.get(), text.data(), text.size()) < 0) return;  // nobody: as good as any
}

// A network of its own, without a device that is up. Without the right to that, one comes with a
// user namespace, in which the process stays the user that it was.
std::string leave_network() {
  if (unshare(CLONE_NEWNET) == 0) return "no network";
  const std::string user = std::to_string(geteuid()), group = std::to_string(getegid());
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
    return std::string("the network of this machine (") + std::strerror(errno) + ")";
  write_file("/proc/self/uid_map", user + " " + user + " 1");
  write_file("/proc/self/setgroups", "deny");
  write_file("/proc/self/gid_map", group + " " + group + " 1");
  return "no network";
}

}  // namespace

std::string confine(uint64_t memory_mib) {
  const std::string memory = limit_memory(memory_mib);
  const std::string network = leave_network();
  const std::string refused = filter_system_calls();
  return (refused.empty() ? "no new sockets, programs or processes"
                          : "new sockets, programs and processes (" + refused + ")") +
         ", " + network + ", " + memory;
}

}  // namespace weir::isolate
