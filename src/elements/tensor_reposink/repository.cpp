// The one table of slots.
#include "elements/tensor_reposink/repository.hpp"

namespace weir {

Repository& repository() {
  static auto& table = *new Repository;  // elements may outlive every static object
  return table;
}

}  // namespace weir
