// What `weir try` knows of a model: how its pixels are prepared and its outputs are read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "core/card/card.hpp"
#include "core/infer/model/model.hpp"
#include "launch/pipeline_description.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct TryModel {
  std::string path;        // of the model file
  std::string engine;      // that the user chose; "": by the file name
  Properties preparation;  // of tensor_preprocess
  // The input picture that the preparation is for, unless a card's file describes it.
  std::optional<card::ImageInput> input;
  std::string mode;                // of tensor_decoder
  Properties decoder;              // further properties of tensor_decoder
  std::string labels;              // path of a label file; "" = none
  std::vector<std::string> names;  // of the classes, as far as they are known
  std::vector<std::string> notes;  // what was assumed, for people
};

// Opens the model, which is a path or a name of the catalogue, and chooses by its card, its
// metadata and its outputs. Errors: those of opening a model; SPEC_MISMATCH when no mode or several
// modes can read the outputs; also for a model that does not take a picture;
// CARD_INVALID for a card that cannot be read or belongs to another file.
Result<TryModel> try_model(const TryOptions& options);
// The same for an open model; options.model is its path.
Result<TryModel> try_model(const TryOptions& options, const infer::Model& model);

}  // namespace weir::app
