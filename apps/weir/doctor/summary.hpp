// The beginning of `weir doctor`: a verdict, what is wrong and how to fix it, and what works, in a
// line for each kind.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "report.hpp"

namespace weir::app {

struct Problem {
  std::string what, reason, fix;
};

// `facts`: the document of `weir doctor --json`. What keeps something that is installed from
// working; an engine that is not installed is no problem.
std::vector<Problem> find_problems(const Json& facts);
// "Weir works", "Weir works, with 2 problems" or "Weir does not work".
std::string verdict(const Json& facts, const std::vector<Problem>& problems);
void print_summary(const Json& facts, const std::vector<Problem>& problems);

}  // namespace weir::app
