// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_reposink/repository.hpp"

#include <string>

namespace weir {

Repository& repository() {
  static auto& table = *new Repository;  // never freed: elements may outlive static objects
  return table;
}

Error lone_end(const char* missing, uint32_t slot) {
  const std::string name = std::string(missing) + " slot-index=" + std::to_string(slot);
  return {
      .code = Code::GRAPH_STALLS,
      .what = "a loop has only one end",
      .offered = "no " + name,
      .needed = "a tensor_reposink and a tensor_reposrc with the same slot-index, in this process",
      .fix = name};
}

}  // namespace weir
