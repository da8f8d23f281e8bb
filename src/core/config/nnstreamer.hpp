// NnstreamerConfiguration: the settings of nnstreamer.ini and the variables NNSTREAMER_*, with
// their origin (docs/compatibility/app-api.md 8.1; docs/guide/configuration.md). Weir's own
// settings take precedence.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/configuration.hpp"

namespace weir::config {

// The content of a folder: sub-plugin files, or libraries with custom filters.
enum class FolderKind { Filters, Decoders, CustomFilters, Converters, Trainers };
inline constexpr std::array kFolderKinds{FolderKind::Filters, FolderKind::Decoders,
                                         FolderKind::CustomFilters, FolderKind::Converters,
                                         FolderKind::Trainers};
// "filters" and so on: the last part of the hard-coded folder.
const char* to_string(FolderKind kind) noexcept;

struct Folder {
  std::string path;
  std::string origin;  // "/etc/nnstreamer.ini:7", a variable, or "hard-coded"
};

class NnstreamerConfiguration {
 public:
  enum class State { Read, NotThere, NoFile /* a folder or a device */, NotNeeded, Unreadable };
  struct Candidate {
    std::string path;
    std::string source;  // "NNSTREAMER_CONF", "built for", "hard-coded", "extra_config_path"
    State state;
  };
  using Environment = Configuration::Environment;

  // Empty if weir.ini has enable=false in the group [nnstreamer].
  static NnstreamerConfiguration load();
  explicit NnstreamerConfiguration(const Environment& environment);

  bool enabled() const noexcept { return enabled_; }
  // Every candidate file in order. The first existing one is read, and the additional file that it
  // names.
  const std::vector<Candidate>& candidates() const noexcept { return candidates_; }
  const std::string& path() const noexcept { return path_; }  // of the file that was read, or ""
  // The additional file that path() names, or "".
  const std::string& extra_path() const noexcept { return extra_path_; }

  // The variable NNSTREAMER_GROUP_KEY (with group and key as spelled) if variables are enabled,
  // then the file, then the additional file.
  std::optional<Setting> find(std::string_view group, std::string_view key) const;
  // All settings of the files and the known variables, by group and key.
  std::vector<Setting> all() const;
  bool enable_envvar() const noexcept { return enable_envvar_; }
  bool enable_symlink() const noexcept { return enable_symlink_; }

  // The search path in order: variable, file, hard-coded, additional file.
  const std::vector<Folder>& folders(FolderKind kind) const {
    return folders_[static_cast<size_t>(kind)];
  }
  // Unreadable files and lines, invalid truth values, paths that are not absolute.
  const std::vector<Error>& faults() const noexcept { return faults_; }
  // The first fault of an existing file that cannot be read or parsed: settings may be missing.
  const std::optional<Error>& unread() const noexcept { return unread_; }

 private:
  void read_first_candidate();
  void read_extra();
  std::vector<Setting> read(const std::string& path, State* state);
  bool get_bool(const char* key);
  void find_folders(FolderKind kind);
  void add_folder(FolderKind kind, const std::optional<Setting>& setting);

  Environment environment_;
  bool enabled_ = true, enable_envvar_ = false, enable_symlink_ = false;
  std::vector<Candidate> candidates_;
  std::string path_, extra_path_;
  std::vector<Setting> main_, extra_;  // in the order of the lines
  std::array<std::vector<Folder>, kFolderKinds.size()> folders_;
  std::vector<Error> faults_;
  std::optional<Error> unread_;
};

const char* to_string(NnstreamerConfiguration::State state) noexcept;

// The weir.ini setting with the same meaning as `setting` of nnstreamer.ini, which takes
// precedence: "[filter] priority_tflite". Nullopt if Weir has none.
std::optional<Setting> overriding(const Setting& setting, const Configuration& weir);

}  // namespace weir::config
