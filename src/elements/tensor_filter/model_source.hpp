// Which engine and which files the settings of tensor_filter mean.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "core/infer/engine_choice.hpp"
#include "core/infer/shared_model.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// MODEL_NOT_FOUND without a model; else as ModuleLibrary says. With a `monitor` the engine is that
// of worker processes. `warning` (may be null) gets what is wrong with accelerator.
Result<infer::ModelSource> model_source(const FilterSettings& settings,
                                        const std::shared_ptr<isolate::Monitor>& monitor,
                                        std::optional<Error>* warning);
// The engine's name as the settings say it, found by the model's files where they say "auto";
// nothing is opened.
std::string framework_name(const FilterSettings& settings);
// The choice that framework=auto makes; none where the settings name an engine, or nobody claims
// the files.
std::optional<infer::EngineChoice> automatic_engine(const FilterSettings& settings);

}  // namespace weir
