// The one table of slots.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_reposink/repository.hpp"

#include <string>

namespace weir {

Repository& repository() {
  static auto& table = *new Repository;  // elements may outlive every static object
  return table;
}

Error lone_end(const char* missing, uint32_t slot) {
  const std::string name = std::string(missing) + " slot-index=" + std::to_string(slot);
  return {Code::GRAPH_STALLS,
          "a loop has one end only",
          "no " + name,
          "both ends with one slot-index, in this program",
          "",
          name};
}

}  // namespace weir
