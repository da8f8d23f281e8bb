// Counting cores from the affinity mask, /sys and the control group.
#include "processor.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace weir::engine {
namespace {

int read_number(const std::string& path, int otherwise) {
  std::ifstream file(path);
  int value = otherwise;
  return file >> value ? value : otherwise;
}

int cores_of_affinity() {
  cpu_set_t mask;
  CPU_ZERO(&mask);
  if (sched_getaffinity(0, sizeof mask, &mask) != 0) return 1;
  std::set<std::pair<int, int>> cores;  // package, core; a CPU of unknown place counts alone
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &mask)) continue;
    const std::string place = "/sys/devices/system/cpu/cpu" + std::to_string(cpu) + "/topology/";
    cores.emplace(read_number(place + "physical_package_id", 0),
                  read_number(place + "core_id", -1 - cpu));
  }
  return std::max<int>(1, static_cast<int>(cores.size()));
}

// "MAX PERIOD" in microseconds, or "max PERIOD" (Linux, admin-guide/cgroup-v2: cpu.max).
int cores_of_quota(const std::string& folder) {
  std::ifstream file(folder + "/cpu.max");
  double quota = 0, period = 0;
  if (!(file >> quota >> period) || period <= 0) return std::numeric_limits<int>::max();
  return std::max(1, static_cast<int>(std::ceil(quota / period)));
}

std::string own_group() {
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("0::/")) return line.substr(3);
  return "/";
}

}  // namespace

int usable_cores() {
  int cores = cores_of_affinity();
  for (std::filesystem::path group = own_group();; group = group.parent_path()) {
    cores = std::min(cores, cores_of_quota("/sys/fs/cgroup" + group.string()));
    if (!group.has_relative_path()) break;
  }
  return cores;
}

}  // namespace weir::engine
