// Builds lists of allowed values and the error for any other value.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/choice.hpp"

#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir {

std::string one_of(std::span<const std::string> words) {
  const std::string out = join(words, ", ");
  return "one of: " + (out.empty() ? "none" : out);
}

Error not_one_of(std::string what, const std::string& offered, std::span<const std::string> words) {
  const std::string close = nearest(offered, words);
  return Error{.code = Code::OPTION_VALUE,
               .what = std::move(what),
               .offered = offered,
               .needed = one_of(words),
               .difference = close.empty() ? "" : "did you mean " + close + "?"};
}

}  // namespace weir
