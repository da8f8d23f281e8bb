// What is known of each decoder and converter on this machine.
#pragma once
#include <string>
#include <vector>

namespace weir::app {

struct ModuleFact {
  std::string name;
  std::string file;
  std::string problem;  // why its file cannot be used; "" when it can
};

// Sorted by name. Each opens every module of its kind.
std::vector<ModuleFact> decoder_facts();
std::vector<ModuleFact> converter_facts();

}  // namespace weir::app
