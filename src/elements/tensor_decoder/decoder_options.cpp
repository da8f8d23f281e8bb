// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/decoder_options.hpp"

#include <algorithm>
#include <charconv>

#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

std::string format_number(float number) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, number);
  return {text, error == std::errc() ? end : text};
}

Result<std::vector<NamedOption>> parse_custom(const std::string& text) {
  std::vector<NamedOption> out;
  for (const auto part : split(text, ",")) {
    const auto item = strip(part);
    if (item.empty()) continue;
    const size_t colon = item.find(':');
    const auto key = strip(item.substr(0, colon));
    if (colon == std::string_view::npos || key.empty())
      return Error{.code = Code::OPTION_SYNTAX,
                   .what = "custom is not a list of options",
                   .offered = "custom=" + text,
                   .needed = "key:value for each option, separated by commas",
                   .difference = "at \"" + std::string(item) + "\"",
                   .fix = "custom=head:yolov8"};
    out.push_back({std::string(key), std::string(strip(item.substr(colon + 1))), true});
  }
  return out;
}

}  // namespace

std::string NamedOption::to_string() const {
  return is_custom ? "custom=" + key + ":" + value : key + "=" + value;
}

Result<DecoderOptions> make_options(const DecoderSettings& s) {
  DecoderOptions out;
  out.numbered = {s.option1, s.option2, s.option3, s.option4, s.option5,
                  s.option6, s.option7, s.option8, s.option9};
  const auto add = [&](const char* key, const std::optional<std::string>& value) {
    if (value) out.named.push_back({key, *value});
  };
  // NaN is set too, so that the decoder rejects it.
  if (!(s.threshold < 0)) add("threshold", format_number(s.threshold));
  if (!(s.iou < 0)) add("iou", format_number(s.iou));
  add("labels", s.labels);
  if (s.max_results > 0) add("max-results", std::to_string(s.max_results));
  add("classes", s.classes);
  auto custom = parse_custom(s.custom.value_or(""));
  if (!custom) return custom.error();
  for (auto& option : *custom) out.named.push_back(std::move(option));
  return out;
}

Status check_custom(const std::string& mode, std::span<const std::string> declared,
                    const DecoderOptions& options) {
  std::vector<std::string> words;  // the corrected list
  const NamedOption* unknown = nullptr;
  std::string close;
  for (const auto& option : options.named) {
    if (!option.is_custom) continue;
    const bool is_known = std::find(declared.begin(), declared.end(), option.key) != declared.end();
    if (is_known) words.push_back(option.key + ":" + option.value);
    if (is_known || unknown) continue;
    unknown = &option;
    close = nearest(option.key, {declared.begin(), declared.end()});
    if (!close.empty()) words.push_back(close + ":" + option.value);
  }
  if (!unknown) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "the mode has no such option",
               .offered = unknown->to_string() + " with mode=" + mode,
               .needed = declared.empty() ? "no option: mode=" + mode + " takes none"
                                          : "one of: " + join(declared, ", "),
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = "tensor_decoder mode=" + mode +
                      (words.empty() ? "" : " custom=" + launch_value(join(words, ",")))};
}

std::vector<Error> remove_undeclared(const std::string& mode, std::span<const std::string> declared,
                                     DecoderOptions* options) {
  std::vector<Error> warnings;
  std::vector<NamedOption> kept;
  for (auto& option : options->named) {
    const auto same = [&](const NamedOption& other) { return other.key == option.key; };
    if (std::find(declared.begin(), declared.end(), option.key) == declared.end()) {
      const std::string close = nearest(option.key, {declared.begin(), declared.end()});
      warnings.push_back(
          {.code = Code::OPTION_VALUE,
           .what = "the mode does not use this option, so it has no effect",
           .offered = option.to_string() + " with mode=" + mode,
           .needed = declared.empty()
                         ? "no option: mode=" + mode + " takes none"
                         : "one of: " + join(declared, ", ", [](const auto& name) { return name; }),
           .difference = close.empty() ? "" : "did you mean " + close + "?"});
    } else if (std::any_of(kept.begin(), kept.end(), same)) {
      warnings.push_back(
          {.code = Code::OPTION_VALUE,
           .what = "an option is set twice; the first value counts",
           .offered = option.to_string(),
           .needed = "one value: " + std::find_if(kept.begin(), kept.end(), same)->to_string()});
    } else {
      kept.push_back(std::move(option));
    }
  }
  options->named = std::move(kept);
  return warnings;
}

}  // namespace weir
