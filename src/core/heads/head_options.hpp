// Readers of the settings that families declare (custom=key:value), and of what models say.
// They throw Failure (OPTION_VALUE) with the setting.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/heads/head.hpp"

namespace weir::heads {

// The error for a setting that cannot be used. `example` is a value that can.
Failure wrong_setting(const HeadOptions& options, const std::string& key, std::string needed,
                      const std::string& example);

// The index of the setting's value among `words`; nullopt if it is not set.
std::optional<size_t> word_setting(const HeadOptions& options, const std::string& key,
                                   std::initializer_list<std::string_view> words);
// A whole number from `min` to `max`; nullopt if it is not set.
std::optional<int64_t> number_setting(const HeadOptions& options, const std::string& key,
                                      int64_t min, int64_t max);
// Numbers between '/', ';', ' ' or ':', none of which separates settings; empty if it is not set.
std::vector<float> numbers_setting(const HeadOptions& options, const std::string& key,
                                   const std::string& example);

// What scores of a model are.
enum class ScoreKind { Automatic, Logits, Probabilities };
ScoreKind score_kind(const HeadOptions& options);  // custom=scores:logits|probabilities
// Whether scores are logits: one of them is below 0 or above 1 by more than rounding explains.
bool are_logits(std::span<const float> scores) noexcept;

// The error for outputs that a family cannot read.
Failure wrong_outputs(const ModelSignature& model, const Family& family);

bool is_integer(ElementType type) noexcept;

// An entry of the model's metadata; "" if there is none.
std::string_view metadata(const ModelSignature& model, const std::string& key);

}  // namespace weir::heads
