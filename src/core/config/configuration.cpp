// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/configuration.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/ini_files.hpp"
#include "core/config/install_paths.hpp"
#include "core/text/text.hpp"
#include "machine/environment.hpp"

namespace weir::config {
namespace {

struct KnownSetting {
  std::string_view group;
  std::string_view key;  // a key that ends in _ takes a suffix: priority_tflite
  std::string_view help;
};

constexpr std::array kSettings{
    KnownSetting{"filter", "priority_",
                 "engines for files with this extension, in order of preference"},
    KnownSetting{"filter", "path", "folders with libraries that provide filters by name"},
    KnownSetting{"filter", "enable_symlink", "a filter's file may be a symbolic link"},
    KnownSetting{"lua", "sandbox", "Lua scripts cannot access files, programs and libraries"},
    KnownSetting{"module", "path", "folders with modules, searched before the built-in one"},
    KnownSetting{"plugin", "prefer_nnstreamer",
                 "Weir does not register elements whose names NNStreamer has"},
    KnownSetting{"network", "require-tls",
                 "elements with protocols of NNStreamer need TLS for other machines"},
    KnownSetting{"nnstreamer", "enable", "nnstreamer.ini and sub-plugins for NNStreamer are used"},
    KnownSetting{"nnstreamer", "library", "the file with the functions that sub-plugins call"},
};

bool matches(const KnownSetting& known, std::string_view key) {
  if (!known.key.ends_with('_')) return key == known.key;
  return key.starts_with(known.key) && key.size() > known.key.size();
}

std::span<const KnownSetting> known_settings() noexcept {
  return kSettings;
}

bool is_known(std::string_view group, std::string_view key) noexcept {
  return std::any_of(kSettings.begin(), kSettings.end(), [&](const auto& known) {
    return known.group == group && matches(known, key);
  });
}

// "[filter] priority_..." for the nearest known setting; "" if none is similar.
std::string nearest_known(std::string_view group, std::string_view key) {
  // Users choose the file extension after the underscore, so only the part before it is compared.
  const size_t underscore = key.rfind('_');
  const bool ends = underscore != std::string_view::npos && underscore + 1 < key.size();
  std::vector<std::string> candidates;
  for (const auto& known : kSettings) {
    std::string whole = std::string(known.group) + "/" + std::string(known.key);
    if (known.key.ends_with('_') && ends) whole += key.substr(underscore + 1);
    candidates.push_back(std::move(whole));
  }
  const std::string close = nearest(std::string(group) + "/" + std::string(key), candidates);
  const size_t slash = close.find('/');
  return close.empty() ? "" : "[" + close.substr(0, slash) + "] " + close.substr(slash + 1);
}

constexpr char kOnlyFile[] = "WEIR_CONFIG";
constexpr char kName[] = "weir/weir.ini";

// ~/.config/weir/weir.ini, "" if there is no home folder.
std::string file_of_user(const Configuration::Environment& environment) {
  const std::string folder = or_empty(environment("XDG_CONFIG_HOME"));
  if (folder.starts_with('/')) return folder + "/" + kName;
  const std::string home = or_empty(environment("HOME"));
  return home.starts_with('/') ? home + "/.config/" + kName : "";
}

bool same(const Setting& a, std::string_view group, std::string_view key) {
  return a.group == group && a.key == key;
}

IniFiles& ini_files() {
  static IniFiles& files = *new IniFiles;  // never destroyed: used until the process ends
  return files;
}

// Adds the variables with this prefix that no file sets.
void add_variables_only(const std::string& prefix, const std::string& key,
                        std::vector<Setting>* out) {
  for (char** each = environ; each && *each; ++each) {
    const std::string_view text(*each);
    const size_t equals = text.find('=');
    if (!text.starts_with(prefix) || equals == std::string_view::npos || equals <= prefix.size())
      continue;
    const std::string name(text.substr(0, equals));
    const auto known = [&](const auto& s) { return variable_name(s.group, s.key) == name; };
    if (environment_variable(name.c_str()) && std::none_of(out->begin(), out->end(), known))
      out->push_back({"filter", key + lower(name.substr(prefix.size())),
                      std::string(text.substr(equals + 1)), name});
  }
}

}  // namespace

std::string variable_name(std::string_view group, std::string_view key) {
  std::string out = "WEIR_" + std::string(group) + "_" + std::string(key);
  for (char& c : out) {
    const bool letter = (c >= 'a' && c <= 'z');
    const bool other = !letter && !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9');
    if (letter) c = static_cast<char>(c - 'a' + 'A');
    if (other) c = '_';
  }
  return out;
}

Configuration Configuration::load() {
  return Configuration(environment_variable);
}

uint64_t Configuration::files_read() {
  return ini_files().reads();
}

Configuration::Configuration(const Environment& environment) : environment_(environment) {
  if (const char* only = environment(kOnlyFile)) {
    if (*only) read(only, true);
    return;
  }
  for (const std::string& path :
       {file_of_user(environment), std::string(kInstalledSettings) + "/" + kName,
        std::string("/etc/") + kName})
    if (!path.empty()) read(path, false);
}

void Configuration::read(const std::string& path, bool wanted) {
  const auto known = [&](const auto& file) { return file.path == path; };
  if (std::any_of(files_.begin(), files_.end(), known)) return;
  std::error_code hidden;
  const bool found = std::filesystem::exists(path, hidden) || hidden;
  auto& file = files_.emplace_back(ConfigurationFile{path, found});
  if (!found && !wanted) return;
  const auto ini = ini_files().read(path);
  const size_t before = entries_.size();
  file.read = true;
  for (Error fault : ini->faults) {
    if (fault.code == Code::FILE_NOT_FOUND) file.read = false;
    if (fault.code == Code::FILE_NOT_FOUND && wanted)
      fault.needed = "an existing file, because WEIR_CONFIG names it";
    possible_faults_.push_back({before, "", "", "", fault});
    faults_.push_back(std::move(fault));
  }
  // Within one file the last line of a key applies.
  for (auto entry = ini->entries.rbegin(); entry != ini->entries.rend(); ++entry) {
    const std::string place = path + ":" + std::to_string(entry->line);
    if (is_known(entry->group, entry->key))
      entries_.push_back({entry->group, entry->key, entry->value, place});
    else
      add_unknown(*entry, place, before);
  }
}

void Configuration::add_unknown(const IniEntry& entry, const std::string& place, size_t before) {
  const auto close = nearest_known(entry.group, entry.key);
  faults_.push_back({.code = Code::OPTION_SYNTAX,
                     .what = place + ": unknown setting",
                     .offered = "[" + entry.group + "] " + entry.key,
                     .needed = "a setting of docs/guide/configuration.md",
                     .difference = close.empty() ? "" : "did you mean " + close + "?"});
  possible_faults_.push_back({before, entry.group, entry.key, close, faults_.back()});
}

std::optional<Setting> Configuration::find(std::string_view group, std::string_view key) const {
  const std::string variable = variable_name(group, key);
  if (const char* value = environment_(variable.c_str()))
    return Setting{std::string(group), std::string(key), value, variable};
  for (const auto& entry : entries_)
    if (same(entry, group, key)) return entry;
  return std::nullopt;
}

std::optional<Error> Configuration::possible_fault(std::string_view group,
                                                   std::string_view key) const {
  if (environment_(variable_name(group, key).c_str())) return std::nullopt;
  const auto has_it = std::find_if(entries_.begin(), entries_.end(),
                                   [&](const auto& entry) { return same(entry, group, key); });
  const auto decides = static_cast<size_t>(has_it - entries_.begin());
  const std::string name = "[" + std::string(group) + "] " + std::string(key);
  for (const auto& each : possible_faults_)
    if (each.before <= decides && (each.group.empty() || lower(each.group) == lower(group) ||
                                   lower(each.key) == lower(key) || each.nearest == name))
      return each.fault;
  return std::nullopt;
}

std::vector<Setting> Configuration::all() const {
  std::vector<Setting> out;
  const auto add = [&](std::string_view group, std::string_view key) {
    const auto there = [&](const auto& s) { return same(s, group, key); };
    if (std::any_of(out.begin(), out.end(), there)) return;
    if (auto setting = find(group, key)) out.push_back(*std::move(setting));
  };
  for (const auto& entry : entries_) add(entry.group, entry.key);
  for (const auto& known : known_settings()) {
    if (!known.key.ends_with('_'))
      add(known.group, known.key);
    else
      add_variables_only(variable_name(known.group, known.key), std::string(known.key), &out);
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    return std::tie(a.group, a.key) < std::tie(b.group, b.key);
  });
  return out;
}

}  // namespace weir::config
