// Finds the card of an open model and formats it as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/card/card.hpp"
#include "core/card/find_card.hpp"
#include "core/infer/model/model.hpp"
#include "report.hpp"

namespace weir::app {

// Whether an input has the shape of a picture, which a card describes.
bool has_pictures(const infer::Model& model);
// What core/card/find_card.hpp needs of an open model.
card::Search card_search(const std::string& model_path, const infer::Model& model);
// Finds the card as core/card/find_card.hpp does. Computes the model's digest.
Result<card::Card> make_card(const std::string& model_path, const infer::Model& model);

// {"name", "path", "task", "decoder", "labels", "preparation"}; the last is the elements between a
// video stream and tensor_filter. `labels` is a list, or null with the reason in "problem" when
// they cannot be loaded.
Json to_json(const card::Card& card, const std::string& model_path);

}  // namespace weir::app
