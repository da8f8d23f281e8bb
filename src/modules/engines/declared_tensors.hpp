// What the options input, inputtype, inputname, output... say of a model's tensors: properties of
// tensor_filter, handed to engines whose files do not say it themselves.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct DeclaredTensor {
  std::string name;               // "" = not said
  uint32_t type = WEIR_TYPE_END;  // WEIR_TYPE_END = not said
  bool has_shape = false;
  std::vector<int64_t> shape;  // outermost-first, with the rank that was written
};

class DeclaredTensors {
 public:
  // Takes `value` when `key` is one of them (in any case): false when it is not. DIMENSION_SYNTAX
  // and TYPE_SYNTAX for texts that cannot be read.
  Result<bool> take(std::string_view key, std::string_view value);
  const std::vector<DeclaredTensor>& inputs() const noexcept { return inputs_; }
  const std::vector<DeclaredTensor>& outputs() const noexcept { return outputs_; }

 private:
  std::vector<DeclaredTensor> inputs_, outputs_;
};

// "3:224:224:1" as dimensions are written: innermost first.
std::string dimension_text(const std::vector<int64_t>& shape);
// Of the type's name; nothing when there is no such type.
std::optional<uint32_t> type_of(std::string_view name);

}  // namespace weir::engine
