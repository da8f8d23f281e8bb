// The card of an opened model, and what it gives to pipelines.
#pragma once
#include "core/card/card.hpp"
#include "core/infer/model.hpp"
#include "report.hpp"

namespace weir::app {

// As core/card/find.hpp says. The model's digest is computed.
Result<card::Card> card_of(const std::string& model_path, const infer::Model& model);

// {"name", "path", "task", "decoder", "labels", "preparation"}: the elements between a video stream
// and tensor_filter. `labels` is a list; null with the reason in "problem" when they cannot be had.
Json to_json(const card::Card& card, const std::string& model_path);

}  // namespace weir::app
