// Where the model of tensor_filter comes from: its engine, its files and, with isolate=process, its
// worker process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <optional>
#include <string>

#include "core/infer/model/shared_model.hpp"
#include "core/infer/module/engine_choice.hpp"
#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// MODEL_NOT_FOUND without a model; otherwise the errors of ModuleLibrary. With a `monitor`, the
// engine runs in worker processes. `warning` (may be null) gets the error of the property
// accelerator.
Result<infer::ModelConfig> make_model_config(const FilterSettings& settings,
                                             const std::shared_ptr<isolate::Monitor>& monitor,
                                             std::optional<Error>* warning);
// The name of the engine: the property, or for "auto" the engine that is found by the model files.
// Opens nothing.
std::string framework_name(const FilterSettings& settings);
// The engine that framework=auto chooses; nullopt if the settings name an engine, or no engine
// supports the files.
std::optional<infer::EngineChoice> automatic_engine(const FilterSettings& settings);

// Null unless isolate=process. While the element exists, it posts a warning when a worker ends.
// With on-crash=error that is an error, which the flow posts.
std::shared_ptr<isolate::Monitor> make_monitor(const FilterSettings& settings, GstElement* element);

// Logs how the worker process is confined, and a warning for what the kernel does not support.
void log_confinement(const isolate::Monitor& monitor, GstElement* element);

void add_worker_stats(const isolate::Monitor& monitor, GstStructure* stats);

}  // namespace weir
