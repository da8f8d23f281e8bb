// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/scheme_checks.hpp"

#include <cmath>

#include "core/text/text.hpp"

namespace weir::decoders {
namespace {

std::string describe_all(std::span<const weir_tensor_info* const> tensors) {
  std::string text =
      std::to_string(tensors.size()) + (tensors.size() == 1 ? " tensor" : " tensors");
  for (size_t i = 0; i < tensors.size() && i < 8; ++i)
    text += (i == 0 ? ": " : ", ") + describe(*tensors[i]);
  return tensors.size() > 8 ? text + ", ..." : text;
}

}  // namespace

Failure wrong_tensors(const SchemeOptions& options,
                      std::span<const weir_tensor_info* const> tensors, const std::string& needed,
                      const std::string& fix) {
  return Failure({.code = Code::SPEC_MISMATCH,
                  .what = options.setting() + " does not accept these tensors",
                  .offered = describe_all(tensors),
                  .needed = needed,
                  .fix = fix});
}

void check_count_and_type(const SchemeOptions& options,
                          std::span<const weir_tensor_info* const> tensors, size_t count,
                          const std::string& needed) {
  bool good = tensors.size() == count;
  for (const auto* info : tensors)
    good = good && info->type == tensors[0]->type && element_bytes(info->type) > 0;
  if (!good) throw wrong_tensors(options, tensors, needed);
}

bool has_dimensions(const weir_tensor_info& info, std::initializer_list<int64_t> dimensions) {
  uint32_t i = 0;
  for (const int64_t extent : dimensions)
    if (dimension(info, i++) != extent) return false;
  for (; i < WEIR_RANK_LIMIT; ++i)
    if (dimension(info, i) != 1) return false;
  return true;
}

float read_number(const SchemeOptions& options, std::string_view text, const char* meaning,
                  float otherwise) {
  text = strip(text);
  if (text.empty()) return otherwise;
  const auto number = parse_double(text);
  if (number && std::isfinite(static_cast<float>(*number))) return static_cast<float>(*number);
  throw Failure({.code = Code::OPTION_SYNTAX,
                 .what = "a parameter of " + options.setting() + " is not a number",
                 .offered = std::string(meaning) + " \"" + std::string(text) +
                            "\" in option3=" + options.parameters,
                 .needed = "a number such as 0.5"});
}

std::vector<std::string_view> split_parameters(const SchemeOptions& options, size_t limit,
                                               const char* grammar) {
  auto parts = split(options.parameters, ":");
  if (parts.size() > limit)
    throw Failure({.code = Code::OPTION_SYNTAX,
                   .what = "option3 has more parameters than " + options.setting() + " takes",
                   .offered = "option3=" + options.parameters,
                   .needed = grammar});
  parts.resize(limit);
  return parts;
}

void check_labels(const SchemeOptions& options, int64_t classes, LabelCount rule,
                  const weir_tensor_info& tensor) {
  const auto labels = static_cast<int64_t>(options.labels.value_or(0));
  if (options.labels && (rule == LabelCount::Equal ? labels == classes : labels >= classes)) return;
  const std::string needed = rule == LabelCount::Equal ? "" : "at least ";
  throw Failure(
      {.code = Code::LABELS_INVALID,
       .what = options.labels ? "the label file does not fit the model's classes"
                              : options.setting() + " needs a label file",
       .offered = options.labels ? std::to_string(labels) + " labels" : "no option2",
       .needed = needed + std::to_string(classes) + " labels for the tensor " + describe(tensor),
       .fix = "option2=/path/to/labels.txt"});
}

}  // namespace weir::decoders
