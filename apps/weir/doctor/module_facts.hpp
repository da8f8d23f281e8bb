// ModuleFact: the state of a decoder or converter on this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace weir::app {

struct ModuleFact {
  std::string name;
  std::string file;
  std::string problem;  // why its file is unusable; "" when it is usable
};

// Sorted by name. Each function opens every module of its kind.
std::vector<ModuleFact> decoder_facts();
std::vector<ModuleFact> converter_facts();

}  // namespace weir::app
