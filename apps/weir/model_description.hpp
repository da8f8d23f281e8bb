// What a model says of itself: the metadata in its file, as its engine gives them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "core/infer/model.hpp"
#include "report.hpp"

namespace weir::app {

// A JSON object with a member "metadata" (null when the engine gives none or no JSON object).
Json model_description(const infer::Model& model);
// The same for people, a block of lines with a title; "" when there is nothing to tell.
std::string description_text(const Json& description);

}  // namespace weir::app
