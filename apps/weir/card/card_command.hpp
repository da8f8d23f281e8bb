// `weir card MODEL`: a model card to fill in.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::app {

struct CardOptions {
  std::string model;   // a path
  std::string engine;  // "": by the file name
  std::string output;  // "": NAME.card.json beside the model; "-": standard output
};
// Writes what the model's file says of its inputs and outputs as a card, with a "?" for what it
// does not say. Never replaces a file.
int write_card(const CardOptions& options);

}  // namespace weir::app
