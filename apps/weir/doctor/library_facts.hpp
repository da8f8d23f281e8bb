// LibraryFact: the state of a library that some of Weir's elements need.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "doctor/plugin_facts.hpp"

namespace weir::app {

struct LibraryFact {
  std::string name;
  std::string state;          // "usable", "not installed" or "not in this build"
  std::string version, file;  // "" when it is not installed
  std::string needed_for;     // what does not work without it
  std::string install;        // "" when it is usable
};

std::vector<LibraryFact> library_facts(const PluginFacts& plugins);

}  // namespace weir::app
