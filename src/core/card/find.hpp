// Which card goes with a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/card/card.hpp"

namespace weir::card {

struct Search {
  std::string model;                    // path of the model file
  std::function<std::string()> sha256;  // of the model file, lower case; called when it is needed
  std::vector<std::string> folders;     // of cards: every *.card.json in them is looked at
  std::vector<ImageInput> from_model;   // what the model's own metadata say; empty = nothing
  std::vector<std::string> labels_from_model;
  std::vector<ImageInput> asked;  // the model's inputs, for the card to fill in
};

// NAME.card.json beside NAME.onnx, whose digest must be the model's; else the card with that digest
// in `folders`; else what the model says itself. CARD_INVALID when the card beside the model is of
// another file; CARD_MISSING, with a card to fill in, when there is none.
Result<Card> find(const Search& search);

// WEIR_CARD_PATH (colon list), then the folder chosen when Weir was built.
std::vector<std::string> card_folders();

// A card for `search` in which what only its author knows is left to fill in.
std::string card_to_fill_in(const Search& search);

}  // namespace weir::card
