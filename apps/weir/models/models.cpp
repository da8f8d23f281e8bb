// `weir models list | info NAME | get NAME`: the catalogue of public models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>

#include "commands.hpp"
#include "models/catalogue.hpp"
#include "models/fetch.hpp"
#include "report.hpp"

namespace weir::app {
namespace {

std::string size_text(uint64_t bytes) {
  constexpr uint64_t kLeastInMegabytes = 100'000;
  char text[32];
  if (bytes < kLeastInMegabytes)
    std::snprintf(text, sizeof text, "%.0f kB", static_cast<double>(bytes) / 1e3);
  else
    std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

uint64_t bytes_of(const CatalogueModel& model) {
  uint64_t out = 0;
  for (const auto& file : model.files) out += file.bytes;
  return out;
}

Json to_json(const CatalogueModel& model) {
  Json files = Json::array();
  for (const auto& file : model.files) {
    Json item{{"name", file.name}};
    if (!file.url.empty()) item["url"] = file.url;
    if (!file.npm.empty()) item["npm"] = file.npm, item["path"] = file.path;
    item["sha256"] = file.sha256;
    item["bytes"] = file.bytes;
    files.push_back(std::move(item));
  }
  Json out{{"name", model.name},
           {"task", model.task},
           {"about", model.about},
           {"licence", model.licence},
           {"files", std::move(files)}};
  if (!model.card.empty()) out["card"] = model.card;
  out["command"] = model.command();
  out["folder"] = folder_of(model).string();
  out["fetched"] = is_fetched(model);
  return out;
}

int list(const std::vector<CatalogueModel>& models, bool json) {
  if (json) {
    Json out = Json::array();
    for (const auto& model : models) out.push_back(to_json(model));
    print(Json{{"models", std::move(out)}});
    return kExitGood;
  }
  std::vector<std::vector<std::string>> rows{
      {"name", "task", "what it does", "size", "licence", ""}};
  for (const auto& model : models)
    rows.push_back({model.name, model.task, model.about, size_text(bytes_of(model)), model.licence,
                    is_fetched(model) ? "downloaded" : ""});
  std::fputs(table(std::move(rows), "").c_str(), stdout);
  std::puts("\nweir models get NAME downloads a model and prints a command that runs it.");
  return kExitGood;
}

int info(const CatalogueModel& model, bool json) {
  if (json) {
    print(to_json(model));
    return kExitGood;
  }
  std::vector<std::vector<std::string>> rows{{"name", model.name},
                                             {"task", model.task},
                                             {"what it does", model.about},
                                             {"licence", model.licence}};
  for (const auto& file : model.files) {
    rows.push_back({"file", file.name + ", " + size_text(file.bytes)});
    rows.push_back(
        {"  from", file.url.empty() ? "npm package " + file.npm + ", " + file.path : file.url});
    rows.push_back({"  sha256", file.sha256});
  }
  if (!model.card.empty()) rows.push_back({"card", model.card});
  rows.push_back(
      {"folder", folder_of(model).string() + (is_fetched(model) ? "" : " (not downloaded)")});
  rows.push_back({"command", model.command()});
  std::fputs(table(std::move(rows), "").c_str(), stdout);
  return kExitGood;
}

int get(const CatalogueModel& model, bool json) {
  const auto say = [json](const std::string& text) {
    std::fprintf(json ? stderr : stdout, "%s\n", text.c_str());
  };
  if (auto status = fetch(model, say); !status) return report(status.error(), json);
  if (json)
    print(to_json(model));
  else
    std::printf("\n%s\n", model.command().c_str());
  return kExitGood;
}

}  // namespace

int models(const ModelsOptions& options) {
  const auto all = read_catalogue();
  if (!all) return report(all.error(), options.json);
  if (options.action == ModelsAction::List) return list(*all, options.json);
  const auto model = model_of(*all, options.name);
  if (!model) return report(model.error(), options.json);
  return options.action == ModelsAction::Get ? get(*model, options.json)
                                             : info(*model, options.json);
}

}  // namespace weir::app
