// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/machine_info.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/text/text.hpp"
#include "machine/usable_cores.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

// The text after "KEY:" in the first line that begins so; "" if there is none.
std::string value_in(const fs::path& file, std::string_view key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const size_t colon = line.find(':');
    if (colon != std::string::npos && strip(std::string_view(line).substr(0, colon)) == key)
      return std::string(strip(std::string_view(line).substr(colon + 1)));
  }
  return "";
}

std::string processor_name(const std::string& root) {
  // The second one is that of many arm boards.
  for (const char* key : {"model name", "Model"})
    if (auto name = value_in(root + "/proc/cpuinfo", key); !name.empty()) return name;
  utsname system{};
  return uname(&system) == 0 ? system.machine : "unknown";
}

// "23 kB" as bytes.
uint64_t bytes_in(const std::string& root, std::string_view key) {
  constexpr uint64_t kKilobyte = 1024;
  const std::string text = value_in(root + "/proc/meminfo", key);
  return text.empty() ? 0 : std::strtoull(text.c_str(), nullptr, 10) * kKilobyte;
}

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::string get_vendor(const std::string& id) {
  const std::pair<const char*, const char*> known[]{
      {"0x8086", "Intel"}, {"0x1002", "AMD"}, {"0x10de", "NVIDIA"}};
  for (const auto& [number, name] : known)
    if (id == number) return name;
  return id.empty() ? "a" : "vendor " + id;
}

std::vector<std::string> gpu_names(const std::string& root) {
  std::vector<std::string> out;
  std::error_code ignored;
  for (const auto& gpu : fs::directory_iterator(root + "/proc/driver/nvidia/gpus", ignored))
    if (auto name = value_in(gpu.path() / "information", "Model"); !name.empty())
      out.push_back(std::move(name));
  for (const auto& node : fs::directory_iterator(root + "/sys/class/drm", ignored)) {
    const std::string name = node.path().filename();
    if (!name.starts_with("renderD")) continue;
    const std::string vendor = get_vendor(first_line(node.path() / "device" / "vendor"));
    // The driver of NVIDIA names its own above.
    if (vendor != "NVIDIA" || out.empty()) out.push_back(vendor + " GPU, /dev/dri/" + name);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

MachineInfo get_machine_info(const std::string& root) {
  return {.processor = processor_name(root),
          .cores = usable_cores(root),
          .gpus = gpu_names(root),
          .memory_bytes = bytes_in(root, "MemTotal"),
          .available_bytes = bytes_in(root, "MemAvailable")};
}

}  // namespace weir::app
