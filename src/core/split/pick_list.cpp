// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/split/pick_list.hpp"

#include <string>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir {
namespace {

Result<size_t> parse_index(std::string_view property, std::string_view text, std::string_view part,
                           const char* needed, const char* example) {
  const auto digits = strip(part);
  const auto index = parse_unsigned(digits);
  if (index) return static_cast<size_t>(*index);
  const auto* at = digits.empty() ? part.data() : digits.data();
  return Error{.code = Code::OPTION_SYNTAX,
               .what = std::string(property) + " cannot be read",
               .offered = std::string(property) + "=" + std::string(text),
               .needed = needed,
               .difference = place_in(text, static_cast<size_t>(at - text.data())),
               .fix = std::string(property) + "=" + example};
}

}  // namespace

Result<std::vector<size_t>> parse_index_list(std::string_view property, std::string_view text,
                                             std::string_view separators) {
  std::vector<size_t> out;
  if (strip(text).empty()) return out;
  for (const auto part : split(text, separators)) {
    const auto index = parse_index(property, text, part, "numbers from 0, separated by ','", "0,2");
    if (!index) return index.error();
    out.push_back(*index);
  }
  return out;
}

Result<TensorGroups> parse_tensor_groups(std::string_view property, std::string_view text) {
  TensorGroups out;
  if (strip(text).empty()) return out;
  for (const auto group : split(text, kPickSeparators)) {
    out.emplace_back();
    for (const auto part : split(group, ":+")) {
      const auto index =
          parse_index(property, text, part,
                      "numbers from 0; ',' between outputs, ':' between tensors of one", "0,1:2");
      if (!index) return index.error();
      out.back().push_back(*index);
    }
    if (out.back().size() > kTensorLimit)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "a group of " + std::string(property) + " has too many tensors",
                   .offered = std::to_string(out.back().size()) + " in group " +
                              std::to_string(out.size() - 1),
                   .needed = "at most 256"};
  }
  return out;
}

Error index_beyond(std::string_view property, std::string_view things, size_t index, size_t count) {
  return Error{
      .code = Code::OPTION_VALUE,
      .what = std::string(property) + " names a " + std::string(things) + " that does not exist",
      .offered = "index " + std::to_string(index),
      .needed = "an index below " + std::to_string(count) + ": there are " + std::to_string(count) +
                " " + std::string(things) + "s",
      .fix = std::string(property) + "=0"};
}

}  // namespace weir
