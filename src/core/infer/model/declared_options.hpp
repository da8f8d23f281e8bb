// The user's description of a model's tensors, for engines whose files do not contain one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "core/infer/model/model.hpp"

namespace weir::infer {

// The options for opening this engine, in order: the user's own; the engine's name if its
// options_json has "framework" (for an engine with several names); those of `declared` that
// options_json lists and the user did not set; the values of weir.ini for options with a "setting"
// that the user did not set.
std::vector<std::pair<std::string, std::string>> options_for(const weir_engine& engine,
                                                             const OpenOptions& options);

// The same without options that do not affect the model: statistics and suspension time.
std::vector<std::pair<std::string, std::string>> get_identity(const weir_engine& engine,
                                                              const OpenOptions& options);

// options_json with everything that tensor_filter declares, for engines that forward it.
extern const char kAllDeclared[];

// For an engine opened with kAllDeclared: the options for `inner`, the engine that runs the model
// in its place.
std::vector<weir_option> options_for_inner(const weir_engine& inner, const weir_open& request);

}  // namespace weir::infer
