// The steps of confinement, from the memory limit to the filter of system calls.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/confinement.hpp"

#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "core/isolate/landlock.hpp"
#include "core/isolate/privileges.hpp"
#include "core/isolate/system_call_filter.hpp"
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
