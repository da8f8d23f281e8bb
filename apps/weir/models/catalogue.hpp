// The catalogue of public models: what they are, where they come from, how to run them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

// One file of a model, from a public address or from an npm package.
struct CatalogueFile {
  std::string name;
  std::string url;        // "" if it comes from a package
  std::string npm, path;  // "@mediapipe/pose@0.5.1675469404", and the file's path in it
  std::string sha256;     // lower case
  uint64_t bytes = 0;
};

struct CatalogueModel {
  std::string name, task, about, licence;
  std::string card;                  // file name of its card; "" = none
  std::string line;                  // a tested command, with {model} for the file; "": none
  std::vector<CatalogueFile> files;  // at least one; the first ones are the model, then labels

  // The command that runs the model once it is fetched: its line, weir try with a photo for what
  // weir try shows, or weir inspect, which says how other models are run.
  std::string command() const;
};

// Reads catalogue.json beside the folders of cards (card::card_folders()). FILE_NOT_FOUND,
// CARD_INVALID.
Result<std::vector<CatalogueModel>> read_catalogue();
// FILE_NOT_FOUND, with the nearest name.
Result<CatalogueModel> find_model(const std::vector<CatalogueModel>& models,
                                  const std::string& name);

// The file of a model of the catalogue; `model` itself if it is a path, or no name of the
// catalogue. MODEL_NOT_FOUND for a model that has not been downloaded.
Result<std::string> file_of_model(const std::string& model);

// Where models are kept: WEIR_MODELS, or weir/models in the user's data folder.
std::filesystem::path models_folder();
std::filesystem::path get_folder(const CatalogueModel& model);
// Whether all files are there with their sizes.
bool is_fetched(const CatalogueModel& model);

}  // namespace weir::app
