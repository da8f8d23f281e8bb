// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/head_options.hpp"

#include <algorithm>

#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::heads {
namespace {

std::optional<std::string_view> find_value(const HeadOptions& options, const std::string& key) {
  const auto found = options.custom.find(key);
  return found == options.custom.end() ? std::nullopt : std::optional(strip(found->second));
}

}  // namespace

Failure wrong_setting(const HeadOptions& options, const std::string& key, std::string needed,
                      const std::string& example) {
  return Failure(
      {.code = Code::OPTION_VALUE,
       .what = "the setting " + key + " cannot be used",
       .offered = "custom=" + key + ":" + std::string(find_value(options, key).value_or("")),
       .needed = std::move(needed),
       .fix = "custom=" + key + ":" + example});
}

std::optional<size_t> word_setting(const HeadOptions& options, const std::string& key,
                                   std::initializer_list<std::string_view> words) {
  const auto value = find_value(options, key);
  if (!value) return std::nullopt;
  for (size_t i = 0; i < words.size(); ++i)
    if (equal_ignoring_case(words.begin()[i], *value)) return i;
  throw wrong_setting(options, key, "one of: " + join(words, ", "), std::string(words.begin()[0]));
}

std::optional<int64_t> number_setting(const HeadOptions& options, const std::string& key,
                                      int64_t min, int64_t max) {
  const auto value = find_value(options, key);
  if (!value) return std::nullopt;
  const auto number = parse_signed(*value);
  if (number && *number >= min && *number <= max) return number;
  throw wrong_setting(options, key,
                      "a whole number from " + std::to_string(min) + " to " + std::to_string(max),
                      std::to_string(std::max<int64_t>(min, 1)));
}

std::vector<float> numbers_setting(const HeadOptions& options, const std::string& key,
                                   const std::string& example) {
  std::vector<float> out;
  const auto value = find_value(options, key);
  if (!value) return out;
  for (const auto part : split(*value, "/; :")) {
    const auto number = parse_double(strip(part));
    if (!number) throw wrong_setting(options, key, "numbers separated by /", example);
    out.push_back(static_cast<float>(*number));
  }
  return out;
}

ScoreKind score_kind(const HeadOptions& options) {
  const auto word = word_setting(options, "scores", {"logits", "probabilities"});
  return !word ? ScoreKind::Automatic : *word == 0 ? ScoreKind::Logits : ScoreKind::Probabilities;
}

bool are_logits(std::span<const float> scores) noexcept {
  constexpr float kRounding = 0.1f;  // of 8-bit outputs, whose range may exceed 0 to 1
  return std::any_of(scores.begin(), scores.end(),
                     [](float score) { return score < -kRounding || score > 1 + kRounding; });
}

Failure wrong_outputs(const ModelSignature& model, const Family& family) {
  return Failure({.code = Code::SPEC_MISMATCH,
                  .what = "the outputs are not those of the head " + std::string(family.name),
                  .offered = model.outputs.empty() ? "no outputs" : model.describe_outputs(),
                  .needed = std::string(family.outputs),
                  .fix = model.input.width > 0
                             ? "tensor_decoder without custom=head:" + std::string(family.name) +
                                   " recognises the head or lists those of this mode"
                             : "custom=input:640:640, the model's input size"});
}

bool is_integer(ElementType type) noexcept {
  return type != ElementType::Float16 && type != ElementType::Float32 &&
         type != ElementType::Float64;
}

std::string_view metadata(const ModelSignature& model, const std::string& key) {
  const auto found = model.metadata.find(key);
  return found == model.metadata.end() ? std::string_view() : std::string_view(found->second);
}

}  // namespace weir::heads
