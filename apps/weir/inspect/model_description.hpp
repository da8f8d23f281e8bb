// Formats the metadata of a model's file as its engine reports them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "core/infer/model/model.hpp"
#include "report.hpp"

namespace weir::app {

// A JSON object with a member "metadata" (null when the engine reports none or no JSON object).
Json model_description(const infer::Model& model);
// The same as lines of text with a title; "" without metadata.
std::string description_text(const Json& description);

}  // namespace weir::app
