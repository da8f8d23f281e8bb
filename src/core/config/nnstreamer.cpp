// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/nnstreamer.hpp"

#include <algorithm>
#include <filesystem>

#include "core/config/ini_files.hpp"
#include "core/config/install_paths.hpp"
#include "core/text/text.hpp"
#include "machine/environment.hpp"

namespace weir::config {
namespace {

namespace fs = std::filesystem;
using State = NnstreamerConfiguration::State;

constexpr char kHardCodedFile[] = "/etc/nnstreamer.ini";
constexpr char kHardCodedFolders[] = "/usr/lib/nnstreamer/";

// The key of a kind's folder and its variable.
struct FolderKeys {
  const char *name, *group, *variable;
};
constexpr FolderKeys kFolderKeys[] = {
    {"filters", "filter", "NNSTREAMER_FILTERS"},
    {"decoders", "decoder", "NNSTREAMER_DECODERS"},
    {"customfilters", "filter", "NNSTREAMER_CUSTOMFILTERS"},
    {"converters", "converter", "NNSTREAMER_CONVERTERS"},
    {"trainers", "trainer", "NNSTREAMER_TRAINERS"},
};
constexpr std::pair<const char*, const char*> kKnown[] = {
    {"common", "enable_envvar"},
    {"common", "enable_symlink"},
    {"common", "extra_config_path"},
    {"filter", "filters"},
    {"filter", "customfilters"},
    {"decoder", "decoders"},
    {"converter", "converters"},
    {"trainer", "trainers"},
    {"pytorch", "enable_use_gpu"},
    {"tensorflow-lite", "subplugin_priority"},
    {"element-restriction", "enable_element_restriction"},
    {"element-restriction", "allowed_elements"},
};

const FolderKeys& get_keys(FolderKind kind) {
  return kFolderKeys[static_cast<size_t>(kind)];
}

// As in GKeyFile, the last line of a key applies.
std::optional<Setting> find_in(const std::vector<Setting>& settings, std::string_view group,
                               std::string_view key) {
  const auto found = std::find_if(settings.rbegin(), settings.rend(),
                                  [&](const auto& s) { return s.group == group && s.key == key; });
  return found == settings.rend() ? std::nullopt : std::optional(*found);
}

// Resolves GKeyFile's escapes; leaves others unchanged.
std::string unescaped(std::string_view value) {
  std::string out;
  for (size_t i = 0; i < value.size(); ++i) {
    constexpr std::string_view kLetters = "sntr\\", kMeanings = " \n\t\r\\";
    const size_t at = value[i] == '\\' && i + 1 < value.size() ? kLetters.find(value[i + 1])
                                                               : std::string_view::npos;
    out += at == std::string_view::npos ? value[i] : kMeanings[at];
    if (at != std::string_view::npos) ++i;
  }
  return out;
}

State find_state(const std::string& path) {
  std::error_code failed;
  const auto type = fs::status(path, failed).type();
  if (type == fs::file_type::not_found) return State::NotThere;
  // Type none: a parent folder cannot be searched, and reading the file reports that.
  return type == fs::file_type::regular || type == fs::file_type::none ? State::Read
                                                                       : State::NoFile;
}

Error not_absolute(const Setting& setting, const std::string& needed) {
  return {.code = Code::OPTION_VALUE,
          .what = setting.origin + ": the path is not absolute and is ignored",
          .offered = "[" + setting.group + "] " + setting.key + "=" + setting.value,
          .needed = needed,
          .fix = setting.key + "=" + fs::absolute(setting.value).lexically_normal().string()};
}

}  // namespace

const char* to_string(FolderKind kind) noexcept {
  return get_keys(kind).name;
}

const char* to_string(State state) noexcept {
  switch (state) {
    case State::Read:
      return "read";
    case State::NotThere:
      return "not found";
    case State::NoFile:
      return "not a regular file";
    case State::NotNeeded:
      return "not needed: an earlier file was read";
    case State::Unreadable:
      return "cannot be read";
  }
  return "";
}

NnstreamerConfiguration NnstreamerConfiguration::load() {
  return NnstreamerConfiguration(environment_variable);
}

NnstreamerConfiguration::NnstreamerConfiguration(const Environment& environment)
    : environment_(environment) {
  const auto enabled = Configuration(environment).find("nnstreamer", "enable");
  enabled_ = !enabled || truth(enabled->value, true);
  if (!enabled_) return;
  read_first_candidate();
  enable_envvar_ = get_bool("enable_envvar");
  enable_symlink_ = get_bool("enable_symlink");
  read_extra();
  for (const FolderKind kind : kFolderKinds) find_folders(kind);
}

void NnstreamerConfiguration::read_first_candidate() {
  std::vector<std::pair<std::string, std::string>> places;
  if (const char* named = environment_("NNSTREAMER_CONF"); named && *named)
    places.emplace_back(named, "NNSTREAMER_CONF");
  places.emplace_back(std::string(kInstalledSettings) + "/nnstreamer.ini", "built for");
  places.emplace_back(kHardCodedFile, "hard-coded");
  for (auto& [path, source] : places) {
    State state = path_.empty() ? find_state(path) : State::NotNeeded;
    if (state == State::Read) {
      main_ = read(path, &state);
      path_ = path;
    } else if (source == "NNSTREAMER_CONF") {
      faults_.push_back({.code = Code::FILE_NOT_FOUND,
                         .what = "NNSTREAMER_CONF does not name a regular file and is ignored",
                         .offered = path,
                         .needed = "a file with groups and keys",
                         .fix = "NNSTREAMER_CONF=/etc/nnstreamer.ini"});
    }
    candidates_.push_back({path, source, state});
  }
}

std::vector<Setting> NnstreamerConfiguration::read(const std::string& path, State* state) {
  static IniFiles& files = *new IniFiles;  // never destroyed: used until the process ends
  const auto ini = files.read(path);
  const auto unread = [](const auto& f) { return f.code == Code::FILE_NOT_FOUND; };
  if (std::any_of(ini->faults.begin(), ini->faults.end(), unread)) *state = State::Unreadable;
  if (!unread_ && !ini->faults.empty()) unread_ = ini->faults.front();
  faults_.insert(faults_.end(), ini->faults.begin(), ini->faults.end());
  std::vector<Setting> out;
  for (const auto& entry : ini->entries)
    out.push_back(
        {entry.group, entry.key, unescaped(entry.value), path + ":" + std::to_string(entry.line)});
  return out;
}

bool NnstreamerConfiguration::get_bool(const char* key) {
  const auto setting = find("common", key);
  if (!setting) return false;
  if (truth(setting->value, false) == truth(setting->value, true))
    return truth(setting->value, false);
  faults_.push_back({.code = Code::OPTION_VALUE,
                     .what = setting->origin + ": neither true nor false",
                     .offered = "[common] " + std::string(key) + "=" + setting->value,
                     .needed = "true or false",
                     .difference = "it is treated as false",
                     .fix = std::string(key) + "=true"});
  return false;
}

void NnstreamerConfiguration::read_extra() {
  const auto setting = find("common", "extra_config_path");
  if (!setting || setting->value.empty()) return;
  if (!fs::path(setting->value).is_absolute()) {
    faults_.push_back(not_absolute(*setting, "the absolute path of a file"));
    candidates_.push_back({setting->value, "extra_config_path", State::NotThere});
    return;
  }
  State state = find_state(setting->value);
  if (state == State::Read) {
    extra_ = read(setting->value, &state);
    extra_path_ = setting->value;
  } else {
    faults_.push_back({.code = Code::FILE_NOT_FOUND,
                       .what = setting->origin + ": extra_config_path does not name a regular file",
                       .offered = setting->value,
                       .needed = "a file with groups and keys"});
  }
  candidates_.push_back({setting->value, "extra_config_path", state});
}

std::optional<Setting> NnstreamerConfiguration::find(std::string_view group,
                                                     std::string_view key) const {
  const std::string variable = "NNSTREAMER_" + std::string(group) + "_" + std::string(key);
  if (enable_envvar_)
    if (const char* value = environment_(variable.c_str()))
      return Setting{std::string(group), std::string(key), value, variable};
  if (auto setting = find_in(main_, group, key)) return setting;
  return find_in(extra_, group, key);
}

std::vector<Setting> NnstreamerConfiguration::all() const {
  std::vector<Setting> out;
  const auto add = [&](std::string_view group, std::string_view key) {
    const auto same = [&](const auto& s) { return s.group == group && s.key == key; };
    if (std::any_of(out.begin(), out.end(), same)) return;
    if (auto setting = find(group, key)) out.push_back(*std::move(setting));
  };
  for (const auto* settings : {&main_, &extra_})
    for (const auto& setting : *settings) add(setting.group, setting.key);
  if (enabled_)
    for (const auto& [group, key] : kKnown) add(group, key);
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    return std::tie(a.group, a.key) < std::tie(b.group, b.key);
  });
  return out;
}

void NnstreamerConfiguration::add_folder(FolderKind kind, const std::optional<Setting>& setting) {
  if (!setting || setting->value.empty()) return;
  if (!fs::path(setting->value).is_absolute()) {
    faults_.push_back(not_absolute(*setting, "the absolute path of a folder"));
    return;
  }
  auto& folders = folders_[static_cast<size_t>(kind)];
  const auto known = [&](const auto& folder) {
    return fs::path(folder.path) / "" == fs::path(setting->value) / "";
  };
  if (std::none_of(folders.begin(), folders.end(), known))
    folders.push_back({setting->value, setting->origin});
}

void NnstreamerConfiguration::find_folders(FolderKind kind) {
  const auto& keys = get_keys(kind);
  const auto of_file = [&](const std::vector<Setting>& settings) {
    auto found = find_in(settings, keys.group, keys.name);
    // The only key with two spellings in use.
    if (!found && kind == FolderKind::Trainers) found = find_in(settings, "trainer", "trainer");
    return found;
  };
  if (enable_envvar_)
    if (const char* value = environment_(keys.variable))
      add_folder(kind, Setting{keys.group, keys.name, value, keys.variable});
  const std::string one = std::string("NNSTREAMER_") + keys.group + "_" + keys.name;
  const char* value = enable_envvar_ ? environment_(one.c_str()) : nullptr;
  add_folder(kind, value ? Setting{keys.group, keys.name, value, one} : of_file(main_));
  add_folder(kind, Setting{keys.group, keys.name, std::string(kHardCodedFolders) + keys.name,
                           "hard-coded"});
  add_folder(kind, of_file(extra_));
}

std::optional<Setting> overriding(const Setting& setting, const Configuration& weir) {
  constexpr std::string_view kPriority = "framework_priority_";
  if (setting.group == "filter" && setting.key.starts_with(kPriority))
    return weir.find("filter", "priority_" + lower(setting.key.substr(kPriority.size())));
  if (setting.group == "common" && setting.key == "enable_symlink")
    return weir.find("filter", "enable_symlink");
  return std::nullopt;
}

}  // namespace weir::config
