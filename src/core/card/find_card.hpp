// Finds the card of a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/card/card.hpp"

namespace weir::card {

// An output of the model, for people who read the card.
struct Output {
  std::string name, type;
  std::vector<int64_t> shape;  // outermost first, -1 = open
};

struct Search {
  std::string model;                    // path of the model file
  std::function<std::string()> sha256;  // of the model file, lower case; called only if needed
  std::vector<std::string> folders;     // searched for *.card.json
  std::vector<ImageInput> from_model;   // from the model's own metadata; may be empty
  std::vector<std::string> labels_from_model;
  // For the card template: the model's inputs, its outputs, and the mode of tensor_decoder that
  // reads them, "" if it is not known.
  std::vector<ImageInput> inputs;
  std::vector<Output> outputs;
  std::string decoder;
};

// Returns NAME.card.json next to NAME.onnx if its digest matches the model, else the card with that
// digest in `folders`, else the model's own metadata. CARD_INVALID if the card next to the model
// describes another file; CARD_MISSING, with a template to fill in, if there is no card.
Result<Card> find(const Search& search);

// The labels of a model by its card: NAME.card.json next to NAME.onnx, or a card in `folders`, with
// the file's digest. `sha256` is called only for cards with the file's name or a model input for
// which `has_input` is true: a file of at most 64 MiB may have been copied to another name. Empty
// if there is no such card, or one without labels.
std::vector<std::string> find_labels(const std::string& model,
                                     const std::function<bool(const ImageInput&)>& has_input,
                                     const std::function<std::string()>& sha256,
                                     const std::vector<std::string>& folders);

// WEIR_CARD_PATH (separated by colons), then the folder chosen when Weir was built.
std::vector<std::string> card_folders();

// A card template for `search`; each "?" stands for what the model's file does not say.
std::string card_to_fill_in(const Search& search);

}  // namespace weir::card
