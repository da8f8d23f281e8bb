// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usable_cores.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

namespace weir {
namespace {

int read_number(const std::string& path, int otherwise) {
  std::ifstream file(path);
  int value = otherwise;
  return file >> value ? value : otherwise;
}

int cores_of_affinity(const std::string& root) {
  cpu_set_t mask;
  CPU_ZERO(&mask);
  if (sched_getaffinity(0, sizeof mask, &mask) != 0) return 1;
  std::set<std::pair<int, int>> cores;  // package, core; a CPU of unknown topology counts alone
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &mask)) continue;
    const std::string place =
        root + "/sys/devices/system/cpu/cpu" + std::to_string(cpu) + "/topology/";
    cores.emplace(read_number(place + "physical_package_id", 0),
                  read_number(place + "core_id", -1 - cpu));
  }
  return std::max<int>(1, static_cast<int>(cores.size()));
}

// "MAX PERIOD" in microseconds, or "max PERIOD" (Linux, admin-guide/cgroup-v2: cpu.max).
int less_by_quota(const std::string& folder, int cores) {
  std::ifstream file(folder + "/cpu.max");
  double quota = 0, period = 0;
  if (!(file >> quota >> period) || period <= 0) return cores;
  return static_cast<int>(std::clamp(std::ceil(quota / period), 1.0, static_cast<double>(cores)));
}

std::string own_group(const std::string& root) {
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("0::/")) return line.substr(3);
  return "/";
}

}  // namespace

int usable_cores(const std::string& root) {
  int cores = cores_of_affinity(root);
  for (std::filesystem::path group = own_group(root);; group = group.parent_path()) {
    cores = less_by_quota(root + "/sys/fs/cgroup" + group.string(), cores);
    if (!group.has_relative_path()) break;
  }
  return cores;
}

}  // namespace weir
