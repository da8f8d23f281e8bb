// Configuration: the settings of weir.ini and the environment, with their origin
// (docs/guide/configuration.md).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/ini.hpp"
#include "weir/result.hpp"

namespace weir::config {

struct Setting {
  std::string group, key, value;
  std::string origin;  // "/etc/weir/weir.ini:3", or the name of an environment variable
};

struct ConfigurationFile {
  std::string path;
  bool found = false;  // true also if that cannot be determined
  bool read = false;   // false also if the file cannot be read; faults() has the reason
};

class Configuration {
 public:
  // The value of an environment variable; null = not set.
  using Environment = std::function<const char*(const char*)>;

  // The configuration of this machine and user at this moment; unchanged files are not read again.
  static Configuration load();
  // Reads the files that may hold settings, in order of precedence. Skips missing files, except one
  // that WEIR_CONFIG names.
  explicit Configuration(const Environment& environment);
  static uint64_t files_read();  // by this process so far

  // The value of [group] key: the variable WEIR_GROUP_KEY, else the first file that has the key.
  std::optional<Setting> find(std::string_view group, std::string_view key) const;
  // A reason why find() may not return what the user intended: the first fault of a file up to the
  // one that has the setting. An unknown name counts if its group or key, or a similar name,
  // matches the setting. Nullopt if a variable sets it.
  std::optional<Error> possible_fault(std::string_view group, std::string_view key) const;
  // All effective settings, by group and key.
  std::vector<Setting> all() const;
  const std::vector<ConfigurationFile>& files() const noexcept { return files_; }
  // Unreadable lines and unknown keys.
  const std::vector<Error>& faults() const noexcept { return faults_; }

 private:
  struct PossibleFault {
    size_t before = 0;                // entries of files with higher precedence
    std::string group, key, nearest;  // an unknown name; "" = the fault may affect any setting
    Error fault;
  };
  void read(const std::string& path, bool wanted);
  void add_unknown(const IniEntry& entry, const std::string& place, size_t before);

  Environment environment_;
  std::vector<ConfigurationFile> files_;
  std::vector<Setting> entries_;  // of all files; the first one of a group and key is effective
  std::vector<Error> faults_;
  std::vector<PossibleFault> possible_faults_;
};

// Returns "WEIR_FILTER_PRIORITY_TFLITE" for [filter] priority_tflite.
std::string variable_name(std::string_view group, std::string_view key);

}  // namespace weir::config
