// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/model_file.hpp"

#include <filesystem>

#include "core/config/installed_file.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"

namespace weir::infer {

namespace fs = std::filesystem;

std::string similar_model_file(const std::string& path) {
  if (auto installed = config::installed_file(path); !installed.empty()) return installed;
  std::error_code ignored;
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".";
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored)) names.push_back(entry.path().filename().string());
  const std::string close = nearest(fs::path(path).filename().string(), names);
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
