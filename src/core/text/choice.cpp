// Words to choose from.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/choice.hpp"

#include "core/text/text.hpp"

namespace weir {

std::string one_of(std::span<const std::string> words) {
  std::string out;
  for (const auto& word : words) out += (out.empty() ? "" : ", ") + word;
  return "one of: " + (out.empty() ? "none" : out);
}

Error not_one_of(std::string what, const std::string& offered, std::span<const std::string> words) {
  const std::string close = nearest(offered, words);
  return Error{Code::OPTION_VALUE,
               std::move(what),
               offered,
               one_of(words),
               close.empty() ? "" : "did you mean " + close + "?",
               ""};
}

}  // namespace weir
