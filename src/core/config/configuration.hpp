// Configuration: what weir.ini and the environment say, and who said it
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
  bool found = false;  // true too where nobody may look whether it is there
  bool read = false;   // false too where it is there and cannot be read: faults() says why
};

class Configuration {
 public:
  // The value of an environment variable; null = not set.
  using Environment = std::function<const char*(const char*)>;

  // Of this machine and user, as it is now; a file that has not changed is not read again.
  static Configuration load();
  // The files in which a setting is looked for, first to last; those that are not there are passed
  // over, but for one that WEIR_CONFIG names.
  explicit Configuration(const Environment& environment);
  static uint64_t files_read();  // by this process, so far

  // [group] key: the variable WEIR_GROUP_KEY, then the first file that has it.
  std::optional<Setting> find(std::string_view group, std::string_view key) const;
  // Why find() may not be what the user meant: the first fault of a file that has the setting, or
  // that is asked before the one that has it. A name that nobody knows is such a fault where group,
  // key or a close name is that of the setting. A variable leaves no doubt.
  std::optional<Error> doubt(std::string_view group, std::string_view key) const;
  // Every setting that has an effect, by group and key.
  std::vector<Setting> all() const;
  const std::vector<ConfigurationFile>& files() const noexcept { return files_; }
  // Lines that cannot be read, keys that nobody asks for.
  const std::vector<Error>& faults() const noexcept { return faults_; }

 private:
  struct Doubt {
    size_t before = 0;                // entries of files that are asked before this one
    std::string group, key, nearest;  // of a name that nobody knows; "" = the file says anything
    Error fault;
  };
  void read(const std::string& path, bool wanted);
  void add_unknown(const IniEntry& entry, const std::string& place, size_t before);

  Environment environment_;
  std::vector<ConfigurationFile> files_;
  std::vector<Setting> entries_;  // of the files; the first of one group and key has an effect
  std::vector<Error> faults_;
  std::vector<Doubt> doubts_;
};

// "WEIR_FILTER_PRIORITY_TFLITE" of [filter] priority_tflite.
std::string variable_of(std::string_view group, std::string_view key);

}  // namespace weir::config
