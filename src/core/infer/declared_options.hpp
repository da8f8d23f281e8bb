// What the user says of a model's tensors, for engines whose files do not say it themselves.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "core/infer/model.hpp"

namespace weir::infer {

// The options that this engine is opened with: the user's own, then the engine's name where its
// options_json has "framework" (an engine that serves under several names), then of `declared`
// those whose names are in its options_json and that the user did not give there, then the values
// of weir.ini for the options that have a "setting" there and that the user did not give.
std::vector<std::pair<std::string, std::string>> options_for(const weir_engine& engine,
                                                             const OpenOptions& options);

// The same without what changes nothing in the model: what the user measures, how long it may idle.
std::vector<std::pair<std::string, std::string>> identity_of(const weir_engine& engine,
                                                             const OpenOptions& options);

// options_json with all that tensor_filter declares, for engines that hand it on.
extern const char kAllDeclared[];

// For an engine that was opened with kAllDeclared: the options that `inner`, which runs the model
// in its place, is opened with.
std::vector<weir_option> options_for_inner(const weir_engine& inner, const weir_open& request);

}  // namespace weir::infer
