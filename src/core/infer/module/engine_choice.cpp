// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/engine_choice.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "core/infer/module/known_engines.hpp"
#include "core/infer/module/model_file.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::infer {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

std::string get_extension(const std::string& path) {
  const size_t dot = path.rfind('.');
  return dot == std::string::npos ? "" : lower(path.substr(dot + 1));
}

Error no_engine_for(const std::string& model) {
  return Error{.code = Code::ENGINE_UNKNOWN,
               .what = "no engine can be selected for this model",
               .offered = model,
               .needed = "a file with the extension .onnx, .tflite, ...",
               .fix = "name the engine: framework=onnxruntime"};
}

// Reports a file that is not there, or is a folder, as such.
Error unknown(const std::string& path) {
  if (path.find("://") != std::string::npos) {
    Error address = no_engine_for(path);
    address.needed = "framework=oip, because the model is the address of a server";
    address.fix = "framework=oip";
    return address;
  }
  const Status is_file = check_model_file(path);
  return is_file ? no_engine_for(path) : is_file.error();
}

std::optional<std::string> engine_of_two(std::span<const std::string> paths) {
  const std::set<std::string> both{get_extension(paths[0]), get_extension(paths[1])};
  if (both == std::set<std::string>{"so", "nb"}) return "vivante";
  if (both == std::set<std::string>{"caffemodel", "prototxt"}) return "caffe";
  if (both == std::set<std::string>{"weights", "cfg"}) return "darknet";
  if (both == std::set<std::string>{"pb", "pbtxt"}) return "tensorflow";
  if (both == std::set<std::string>{"pb"} && paths[0] != paths[1]) return "caffe2";
  return std::nullopt;
}

// The names of a list, spelled as in module files.
Names engines_in(std::string_view list) {
  Names out;
  for (const auto part : split(list, ",; ")) {
    const auto word = strip(part);
    const auto* known = known_engine(word);
    if (!word.empty()) out.emplace_back(known ? known->name : word);
  }
  return out;
}

class Chooser {
 public:
  Chooser(std::span<const std::string> installed, std::string extension)
      : installed_(installed), extension_(std::move(extension)) {}

  // `settings` have the highest priority first.
  std::optional<EngineChoice> choose(const std::vector<config::Setting>& settings) {
    std::string why;
    Names wanted;
    for (const auto& setting : settings) {
      const std::string place = setting.key + " (" + setting.origin + ")";
      const Names list = engines_in(setting.value);
      if (list.empty()) continue;
      if (auto found = find_first_installed(list, "first installed engine of " + place))
        return found;
      why += (why.empty() ? "none of " : "; none of ") + place + " is installed";
      if (wanted.empty()) wanted = list;
    }
    const auto preferred = preferred_engines(extension_);
    if (auto found = find_first_installed(Names(preferred.begin(), preferred.end()), why))
      return found;
    if (const KnownEngine* known = known_engine_for(extension_))
      return choice(std::string(known->name), why);
    // No other engine matches: the error for the first preference has the install command.
    if (!wanted.empty()) return choice(wanted[0], why);
    return std::nullopt;
  }
  void add_others(EngineChoice* chosen) {
    for (const auto& known : known_engines()) {
      const auto extensions = split(known.extensions, ",");
      if (std::find(extensions.begin(), extensions.end(), extension_) != extensions.end())
        claimed_.emplace_back(known.name);
    }
    for (const auto& name : claimed_)
      if (is_installed(name) && name != chosen->engine &&
          std::find(chosen->others.begin(), chosen->others.end(), name) == chosen->others.end())
        chosen->others.push_back(name);
  }

 private:
  std::optional<EngineChoice> find_first_installed(const Names& list, const std::string& why) {
    claimed_.insert(claimed_.end(), list.begin(), list.end());
    const auto found =
        std::find_if(list.begin(), list.end(), [&](const auto& n) { return is_installed(n); });
    if (found == list.end()) return std::nullopt;
    return choice(*found, why);
  }
  EngineChoice choice(const std::string& engine, const std::string& why) const {
    EngineChoice out{engine, "the file has the extension ." + extension_, {}};
    if (!why.empty()) out.reason += "; " + why;
    return out;
  }
  bool is_installed(const std::string& name) const {
    return std::binary_search(installed_.begin(), installed_.end(), name);
  }
  std::span<const std::string> installed_;
  std::string extension_;
  Names claimed_;
};

// The settings that name preferred engines, highest priority first.
std::vector<config::Setting> priorities(const std::string& extension,
                                        const config::Configuration& weir,
                                        const config::NnstreamerConfiguration* nnstreamer) {
  std::vector<config::Setting> out;
  if (auto own = weir.find("filter", "priority_" + extension)) out.push_back(*std::move(own));
  if (auto theirs =
          nnstreamer ? nnstreamer->find("filter", "framework_priority_" + extension) : std::nullopt)
    out.push_back(*std::move(theirs));
  return out;
}

}  // namespace

std::string EngineChoice::to_string() const {
  const std::string list = join(others, ", ");
  return engine + ": " + reason + "; other candidates: " + (list.empty() ? "none" : list);
}

Result<EngineChoice> choose_engine(std::span<const std::string> paths,
                                   std::span<const std::string> installed,
                                   const config::Configuration& configuration,
                                   const config::NnstreamerConfiguration* nnstreamer) {
  std::error_code ignored;
  if (!paths.empty() && fs::is_directory(paths[0], ignored)) {
    if (!std::binary_search(installed.begin(), installed.end(), "nnfw")) return unknown(paths[0]);
    return EngineChoice{"nnfw", "the model is a folder", {}};
  }
  if (paths.size() == 2)
    if (const auto engine = engine_of_two(paths))
      return EngineChoice{*engine, "by the names of the model's files", {}};
  if (paths.size() != 1)
    return no_engine_for(paths.empty() ? "no model" : paths[0] + " and others");
  const std::string extension = get_extension(paths[0]);
  if (extension.empty()) return unknown(paths[0]);
  Chooser chooser(installed, extension);
  auto chosen = chooser.choose(priorities(extension, configuration, nnstreamer));
  if (!chosen) return unknown(paths[0]);
  chooser.add_others(&*chosen);
  return *chosen;
}

}  // namespace weir::infer
