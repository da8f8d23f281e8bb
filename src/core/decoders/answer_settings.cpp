// Reads and declares the options of the modes that write results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/answer_settings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/decoders/option_text.hpp"
#include "core/heads/families.hpp"
#include "core/text/pasted.hpp"
#include "core/text/text.hpp"
#include "weir/label_file.hpp"

namespace weir::decoders {
namespace {

constexpr size_t kMostResults = 65536;

Failure invalid(const std::string& option, std::string_view value, std::string needed,
                std::string fix) {
  return Failure({.code = Code::OPTION_VALUE,
                  .what = "the value of " + option + " cannot be used",
                  .offered = option + "=" + std::string(value),
                  .needed = std::move(needed),
                  .fix = std::move(fix)});
}

// A part of 1: a score or an overlap.
std::optional<float> read_part(const Options& options, const std::string& option, const char* fix) {
  const auto text = options.get(option);
  if (!text || text->empty()) return std::nullopt;
  float value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc() || end != text->data() + text->size() || !(value >= 0 && value <= 1))
    throw invalid(option, *text, "a number from 0 to 1", fix);
  return value;
}

size_t read_most_results(const Options& options, size_t otherwise) {
  const auto text = options.get("max-results");
  if (!text || text->empty()) return otherwise;
  size_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc() || end != text->data() + text->size() || value == 0 ||
      value > kMostResults)
    throw invalid("max-results", *text, "a whole number from 1 to 65536", "max-results=100");
  return value;
}

bool is_number(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void set_text(const std::string& key, const std::string& value, AnswerSettings* out) {
  if (key == "labels")
    out->labels = read_label_file("labels", value);
  else if (key == "classes")
    out->classes = parse_name_list(value);
  else if (key == "head")
    out->head = value;
  else if (key == "name")
    out->name = value;
  else
    out->custom[key] = value;
}

}  // namespace

std::vector<int32_t> AnswerSettings::class_indices(const std::vector<std::string>& names) const {
  std::vector<int32_t> out;
  for (const std::string& name : classes) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) {
      out.push_back(static_cast<int32_t>(found - names.begin()));
    } else if (is_number(name) && name.size() < 8) {
      out.push_back(std::stoi(name));
    } else {
      const std::string close = nearest(name, names);
      throw Failure({.code = Code::OPTION_VALUE,
                     .what = "a class is neither a label nor a number",
                     .offered = "classes=" + name,
                     .needed = names.empty() ? "numbers of classes, or labels=FILE for names"
                                             : "one of the " + std::to_string(names.size()) +
                                                   " labels, or a number",
                     .difference = close.empty() ? "" : "did you mean " + close + "?",
                     .fix = close.empty() ? "" : "classes=" + launch_value(close)});
    }
  }
  return out;
}

AnswerSettings read_answer_settings(const Options& options) {
  AnswerSettings out;
  out.threshold = read_part(options, "threshold", "threshold=0.5");
  out.iou = read_part(options, "iou", "iou=0.45").value_or(out.iou);
  out.max_results = read_most_results(options, out.max_results);
  constexpr std::string_view kNumbers[] = {"threshold", "iou", "max-results", "input"};
  for (const weir_option& option : options.all()) {
    if (!option.key || !option.value || !*option.value) continue;
    const std::string_view key = option.key;
    if (std::find(std::begin(kNumbers), std::end(kNumbers), key) == std::end(kNumbers))
      set_text(option.key, option.value, &out);
  }
  if (options.get("input")) {
    const FrameSize size = read_size(options, "input", "the size of the model's input");
    out.input = {size.width, size.height};
  }
  return out;
}

std::string answer_options_json(uint32_t tasks) {
  std::string out =
      R"([{"name":"threshold","type":"number","default":"","help":"Minimum score, 0 to 1"},)"
      R"({"name":"iou","type":"number","default":"0.45","help":"Overlap beyond which the weaker of two boxes is removed"},)"
      R"({"name":"labels","type":"file","default":"","help":"Label file: one label per line"},)"
      R"({"name":"max-results","type":"integer","default":"100","help":"Maximum number of objects of a frame"},)"
      R"({"name":"classes","type":"text","default":"","help":"Classes to keep: labels or numbers, separated by commas"},)"
      R"({"name":"head","type":"text","default":"","help":"Family of the model's outputs"},)"
      R"({"name":"input","type":"text","default":"","help":"Size of the model's input, W:H"},)"
      R"({"name":"name","type":"text","default":"","help":"Name of the source of the results"})";
  std::vector<std::string> known;
  for (const heads::Family* family : heads::all_families()) {
    if (!(family->tasks & tasks)) continue;
    for (const std::string& name : parse_name_list(family->custom)) {
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      known.push_back(name);
      out += R"(,{"name":")" + name + R"(","type":"text","default":"","help":"Of the head )" +
             std::string(family->name) + R"("})";
    }
  }
  return out + "]";
}

}  // namespace weir::decoders
