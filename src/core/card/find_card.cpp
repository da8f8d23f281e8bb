// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/find_card.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/config/install_paths.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "machine/environment.hpp"

namespace weir::card {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kMaxCopyBytes = uintmax_t{64} << 20;
constexpr uintmax_t kMaxLabelBytes = uintmax_t{16} << 20;

std::vector<std::string> cards_in(const std::string& folder) {
  std::vector<std::string> out;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().filename().string().ends_with(".card.json"))
      out.push_back(entry.path().string());
  std::sort(out.begin(), out.end());
  return out;
}

std::string layout_name(Layout layout) {
  return layout == Layout::Nhwc ? "NHWC" : "NCHW";
}

const char* color_name(Color color) {
  return color == Color::Gray ? "GRAY8" : color == Color::Rgb ? "RGB" : "BGR";
}

const char* fit_name(Fit fit) {
  return fit == Fit::Stretch ? "stretch" : fit == Fit::Crop ? "crop" : "letterbox";
}

// `has_pixels`: it is known how the pixels are prepared.
nlohmann::ordered_json input_to_fill_in(const ImageInput& input, bool has_pixels) {
  nlohmann::ordered_json out{{"name", input.name},
                             {"type", to_string(input.type)},
                             {"shape", input.shape},
                             {"layout", layout_name(input.layout)}};
  const bool is_gray = input.channels() == 1;
  out["color"] = has_pixels ? color_name(input.color) : is_gray ? "GRAY8" : "RGB or BGR?";
  out["mean"] = {"?"};
  out["scale"] = {"?"};
  if (has_pixels) out["mean"] = input.mean;
  if (has_pixels) out["scale"] = input.scale;
  out["resize"] = has_pixels ? fit_name(input.resize) : "stretch, crop or letterbox?";
  if (has_pixels && input.resize == Fit::Letterbox) out["padding"] = input.padding;
  return out;
}

// Whether the folders have this card too, as they have those of the catalogue's models.
bool is_installed(const Search& search, const Card& own) {
  return std::any_of(search.folders.begin(), search.folders.end(), [&](const auto& folder) {
    const auto paths = cards_in(folder);
    return std::any_of(paths.begin(), paths.end(), [&](const auto& path) {
      std::error_code ignored;
      if (fs::equivalent(path, own.path, ignored)) return false;
      const auto card = read(path);
      return card && card->sha256 == own.sha256;
    });
  });
}

// Reads the card next to the model.
Result<Card> read_own_card(const std::string& path, const Search& search) {
  auto card = read(path);
  if (!card || card->sha256 == search.sha256()) return card;
  Error error{.code = Code::CARD_INVALID,
              .what = "the card next to the model belongs to a different file",
              .offered = path + ": sha256 " + card->sha256,
              .needed = "sha256 " + search.sha256()};
  if (is_installed(search, *card)) {
    error.needed += ": download the model again";
    return error;
  }
  error.needed +=
      ": if you trained the model again, correct the card by the fix; if you downloaded it, "
      "download it again";
  error.fix = "sed -i s/" + card->sha256 + "/" + search.sha256() + "/I " + shell_word(path);
  return error;
}

Card card_from_model(const Search& search) {
  Card card;
  card.name = card.model = fs::path(search.model).filename().string();
  card.sha256 = search.sha256();
  card.inputs = search.from_model;
  card.labels.names = search.labels_from_model;
  if (!card.labels.names.empty()) card.decoder = "image_labeling";
  return card;
}

}  // namespace

std::vector<std::string> card_folders() {
  std::vector<std::string> out;
  if (const char* text = environment_variable("WEIR_CARD_PATH"))
    for (const auto part : split(text, ":"))
      if (!part.empty()) out.emplace_back(part);
  out.emplace_back(config::kInstalledCards);
  return out;
}

std::string card_to_fill_in(const Search& search) {
  nlohmann::ordered_json card{{"name", fs::path(search.model).stem().string()},
                              {"model", fs::path(search.model).filename().string()},
                              {"sha256", search.sha256()},
                              {"task", "?"}};
  const bool has_pixels = !search.from_model.empty();
  for (const auto& input : has_pixels ? search.from_model : search.inputs)
    card["inputs"].push_back(input_to_fill_in(input, has_pixels));
  for (const auto& output : search.outputs)
    card["outputs"].push_back(
        {{"name", output.name}, {"type", output.type}, {"shape", output.shape}, {"meaning", "?"}});
  card["labels"] = search.labels_from_model;
  card["decoder"] = search.decoder.empty() ? "classification?" : search.decoder;
  card["provenance"] = {{"source", "?"}, {"licence", "?"}};
  return card.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Result<Card> find(const Search& search) {
  const std::string own = fs::path(search.model).replace_extension(".card.json").string();
  std::error_code ignored;
  if (fs::exists(own, ignored)) return read_own_card(own, search);
  for (const auto& folder : search.folders)
    for (const auto& path : cards_in(folder)) {
      auto card = read(path);
      if (!card) return card;
      if (card->sha256 == search.sha256()) return card;
    }
  if (!search.from_model.empty()) return card_from_model(search);
  return Error{.code = Code::CARD_MISSING,
               .what = "no model card describes how the pixels must be prepared",
               .offered = search.model,
               .needed = own + ", or a card with the model's digest in " + search.folders.back(),
               .fix = "fill in this card:\n" + card_to_fill_in(search)};
}

std::vector<std::string> find_labels(const std::string& model,
                                     const std::function<bool(const ImageInput&)>& has_input,
                                     const std::function<std::string()>& sha256,
                                     const std::vector<std::string>& folders) {
  std::error_code ignored;
  const bool is_small = fs::file_size(model, ignored) <= kMaxCopyBytes;
  std::vector<std::string> paths{fs::path(model).replace_extension(".card.json").string()};
  for (const auto& folder : folders)
    for (auto& path : cards_in(folder)) paths.push_back(std::move(path));
  for (const auto& path : paths) {
    const auto card = read(path);
    const bool may_be =
        card && (card->model == fs::path(model).filename() ||
                 (is_small && std::any_of(card->inputs.begin(), card->inputs.end(), has_input)));
    if (!may_be || card->sha256 != sha256()) continue;
    const auto labels = read_labels(*card, model, folders);
    return labels ? *labels : std::vector<std::string>();
  }
  return {};
}

Result<std::vector<std::string>> read_labels(const Card& card, const std::string& model_path,
                                             const std::vector<std::string>& folders) {
  if (card.labels.file.empty()) return card.labels.names;
  std::vector<fs::path> places{fs::path(model_path).parent_path(),
                               fs::path(card.path).parent_path()};
  places.insert(places.end(), folders.begin(), folders.end());
  for (const auto& place : places) {
    std::error_code ignored;
    const fs::path path = place / card.labels.file;
    if (!fs::is_regular_file(path, ignored)) continue;
    if (fs::file_size(path, ignored) > kMaxLabelBytes)
      return Error{.code = Code::LABELS_INVALID,
                   .what = "the label file that the card names is too large",
                   .offered = path.string(),
                   .needed = "at most 16 MiB"};
    std::ifstream file(path);
    std::vector<std::string> labels;
    for (std::string line; std::getline(file, line);) {
      if (line.ends_with('\r')) line.pop_back();
      labels.push_back(line);
    }
    const auto skip = static_cast<std::ptrdiff_t>(std::min(card.labels.skip, labels.size()));
    labels.erase(labels.begin(), labels.begin() + skip);
    if (!labels.empty()) return labels;
  }
  return Error{
      .code = Code::LABELS_INVALID,
      .what = "the label file that the card names does not exist, or is empty",
      .offered = card.labels.file,
      .needed = "a file with one label on each line, next to the model: " + places[0].string()};
}

}  // namespace weir::card
