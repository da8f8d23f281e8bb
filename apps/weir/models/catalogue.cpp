// SPDX-License-Identifier: LGPL-2.1-or-later
#include "models/catalogue.hpp"

#include <glib.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "core/card/find_card.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "machine/environment.hpp"
#include "machine/install_command.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

std::string member_text(const Json& object, const char* key) {
  const auto at = object.find(key);
  return at != object.end() && at->is_string() ? at->get<std::string>() : "";
}

CatalogueFile file_from(const Json& json) {
  CatalogueFile out{.name = member_text(json, "name"),
                    .url = member_text(json, "url"),
                    .npm = member_text(json, "npm"),
                    .path = member_text(json, "path"),
                    .sha256 = member_text(json, "sha256")};
  if (json.contains("bytes") && json["bytes"].is_number_unsigned())
    out.bytes = json["bytes"].get<uint64_t>();
  return out;
}

bool is_complete(const CatalogueFile& file) {
  const bool is_plain = !file.name.empty() && file.name.find('/') == std::string::npos &&
                        file.name != "." && file.name != "..";
  return is_plain && file.sha256.size() == 64 && file.bytes > 0 &&
         (file.url.starts_with("https://") || (file.url.empty() && !file.path.empty()));
}

Error invalid(const fs::path& path, const std::string& offered) {
  return Error{.code = Code::CARD_INVALID,
               .what = "the catalogue of models cannot be used",
               .offered = path.string() + ": " + offered,
               .needed = "an object with a list \"models\", each with name and files",
               .fix = "install Weir again: " + std::string(kInstallWeir)};
}

Result<std::vector<CatalogueModel>> read_from(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("models") || !json["models"].is_array())
    return invalid(path, "not a catalogue");
  std::vector<CatalogueModel> out;
  for (const Json& item : json["models"]) {
    CatalogueModel model{.name = member_text(item, "name"),
                         .task = member_text(item, "task"),
                         .about = member_text(item, "about"),
                         .licence = member_text(item, "licence"),
                         .card = member_text(item, "card"),
                         .line = member_text(item, "line"),
                         .files = {}};
    if (item.contains("files") && item["files"].is_array())
      for (const Json& file : item["files"]) model.files.push_back(file_from(file));
    const bool is_plain =
        !model.name.empty() && model.name.find('/') == std::string::npos && model.name[0] != '.';
    if (!is_plain || model.files.empty() ||
        !std::all_of(model.files.begin(), model.files.end(), is_complete))
      return invalid(path, "model '" + model.name + "'");
    out.push_back(std::move(model));
  }
  return out;
}

}  // namespace

Result<std::vector<CatalogueModel>> read_catalogue() {
  const auto folders = card::card_folders();
  for (const auto& folder : folders) {
    const fs::path path = fs::path(folder).parent_path() / "catalogue.json";
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) return read_from(path);
  }
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "the catalogue of models cannot be found",
               .offered = "beside " + join(folders, ", "),
               .needed = "catalogue.json",
               .fix = std::string(kInstallWeir) + ", or WEIR_CARD_PATH=/path/to/models/cards"};
}

Result<CatalogueModel> find_model(const std::vector<CatalogueModel>& models,
                                  const std::string& name) {
  std::vector<std::string> names;
  for (const auto& model : models) {
    if (model.name == name) return model;
    names.push_back(model.name);
  }
  const std::string close = nearest(name, names);
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "the catalogue has no such model",
               .offered = name,
               .needed = "a name that weir models list prints",
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = close.empty() ? "weir models list" : close};
}

std::string CatalogueModel::command() const {
  constexpr const char* kOfPhotos[] = {"classification", "depth",        "detection",
                                       "pose",           "segmentation", "text"};
  const std::string file = shell_word((get_folder(*this) / files[0].name).string());
  if (!line.empty()) {
    constexpr std::string_view kFile = "{model}";
    const size_t at = line.find(kFile);
    return at == std::string::npos ? line
                                   : line.substr(0, at) + file + line.substr(at + kFile.size());
  }
  const bool is_shown =
      std::find(std::begin(kOfPhotos), std::end(kOfPhotos), task) != std::end(kOfPhotos);
  return is_shown ? "weir try " + name + " photo.jpg" : "weir inspect " + file;
}

Result<std::string> file_of_model(const std::string& model) {
  std::error_code ignored;
  if (fs::exists(model, ignored) || model.find('/') != std::string::npos) return model;
  const auto all = read_catalogue();
  if (!all) return model;  // the engine reports that there is no such file
  const auto known = find_model(*all, model);
  if (!known) return model;
  if (is_fetched(*known)) return (get_folder(*known) / known->files[0].name).string();
  return Error{.code = Code::MODEL_NOT_FOUND,
               .what = "the model has not been downloaded",
               .offered = model,
               .needed = (get_folder(*known) / known->files[0].name).string(),
               .fix = "weir models get " + model};
}

fs::path models_folder() {
  if (const char* chosen = environment_variable("WEIR_MODELS"); chosen && *chosen) return chosen;
  return fs::path(g_get_user_data_dir()) / "weir" / "models";
}

fs::path get_folder(const CatalogueModel& model) {
  return models_folder() / model.name;
}

bool is_fetched(const CatalogueModel& model) {
  return std::all_of(model.files.begin(), model.files.end(), [&](const CatalogueFile& file) {
    std::error_code failed;
    const auto bytes = fs::file_size(get_folder(model) / file.name, failed);
    return !failed && bytes == file.bytes;
  });
}

}  // namespace weir::app
