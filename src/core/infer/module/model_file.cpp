// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/model_file.hpp"

#include <algorithm>
#include <filesystem>

#include "core/config/installed_file.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"

namespace weir::infer {

namespace fs = std::filesystem;

namespace {

// Whether each word of the names is close to the other's: libnnstreamer_customfilter_scaler.so has
// little in common with libnnstreamer_customfilter_passthrough.so but the prefix that all have.
bool has_close_words(std::string_view name, std::string_view other) {
  constexpr size_t kShort = 3;  // as v1
  const auto words = split(name, "_-."), others = split(other, "_-.");
  if (words.size() != others.size()) return true;
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string candidate(others[i]);
    if (std::max(words[i].size(), candidate.size()) > kShort &&
        nearest(words[i], {&candidate, 1}).empty())
      return false;
  }
  return true;
}

}  // namespace

std::string similar_model_file(const std::string& path) {
  if (auto installed = config::installed_file(path); !installed.empty()) return installed;
  std::error_code ignored;
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".";
  std::vector<std::string> names;
  const std::string wanted = fs::path(path).filename().string();
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (const auto name = entry.path().filename().string();
        has_close_words(wanted, name) && entry.is_regular_file(ignored))
      names.push_back(name);
  const std::string close = nearest(wanted, names);
  return close.empty() ? "" : (fs::path(path).parent_path() / close).string();
}

Status check_model_file(const std::string& path) {
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) return ok();
  if (fs::is_directory(path, ignored))
    return Error{
        .code = Code::MODEL_NOT_FOUND,
        .what = "the model is a folder",
        .offered = path,
        .needed = "the path of a model file, such as " + (fs::path(path) / "NAME.onnx").string()};
  const std::string similar = similar_model_file(path);
  const std::string fix = similar.empty() ? "" : "model=" + launch_value(similar);
  if (!config::installed_file(path).empty())
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "the model file does not exist",
                 .offered = path,
                 .needed = "a file that can be read",
                 .difference = "Weir is installed below another prefix",
                 .fix = fix};
  const std::string close = fs::path(similar).filename().string();
  return Error{.code = Code::MODEL_NOT_FOUND,
               .what = "the model file does not exist",
               .offered = path,
               .needed = "a file that can be read",
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = fix};
}

}  // namespace weir::infer
