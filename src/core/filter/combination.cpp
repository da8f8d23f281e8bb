// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/combination.hpp"

#include <algorithm>
#include <string>

#include "core/text/text.hpp"

namespace weir {
namespace {

Error unreadable(std::string_view property, std::string_view text, std::string_view part,
                 const char* needed, const char* fix) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = std::string(property) + " cannot be read",
               .offered = std::string(text),
               .needed = needed,
               .difference = "at \"" + std::string(part) + "\"",
               .fix = fix};
}

}  // namespace

Result<std::vector<size_t>> parse_input_combination(std::string_view text) {
  std::vector<size_t> out;
  if (strip(text).empty()) return out;
  for (const auto raw : split(text, ",")) {
    const auto part = strip(raw);
    const auto index = parse_unsigned(part);
    if (!index || *index >= kTensorLimit)
      return unreadable("input-combination", text, part, "a comma list of tensor indices, 0 to 255",
                        "input-combination=0,2");
    out.push_back(static_cast<size_t>(*index));
  }
  return out;
}

Result<OutputCombination> parse_output_combination(std::string_view text) {
  OutputCombination out;
  if (strip(text).empty()) return out;
  for (const auto raw : split(text, ",")) {
    const auto part = strip(raw);
    const bool input = !part.empty() && (part[0] == 'i' || part[0] == 'I');
    const bool output = !part.empty() && (part[0] == 'o' || part[0] == 'O');
    const auto index = input || output ? parse_unsigned(part.substr(1)) : std::nullopt;
    if (!index || *index >= kTensorLimit)
      return unreadable("output-combination", text, part,
                        "a comma list of i<N> (input tensor) and o<N> (model output)",
                        "output-combination=i0,o0");
    (input ? out.inputs : out.outputs).push_back(static_cast<size_t>(*index));
  }
  std::sort(out.outputs.begin(), out.outputs.end());
  out.outputs.erase(std::unique(out.outputs.begin(), out.outputs.end()), out.outputs.end());
  return out;
}

Result<std::vector<TensorSpec>> choose_tensors(const std::vector<TensorSpec>& tensors,
                                               const std::vector<size_t>& choice,
                                               std::string_view property) {
  if (choice.empty()) return tensors;
  std::vector<TensorSpec> out;
  for (const size_t index : choice) {
    if (index >= tensors.size())
      return Error{.code = Code::OPTION_VALUE,
                   .what = std::string(property) + " names a tensor that does not exist",
                   .offered = "index " + std::to_string(index),
                   .needed = "an index below " + std::to_string(tensors.size()),
                   .fix = std::string(property) + "=0"};
    out.push_back(tensors[index]);
  }
  return out;
}

}  // namespace weir
