// DeclaredTensors: a model's tensors as the user declares them by the properties input, inputtype,
// inputname, output... of tensor_filter, for engines whose files lack this information.
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
  std::string name;               // "" = not given
  uint32_t type = WEIR_TYPE_END;  // WEIR_TYPE_END = not given
  bool has_shape = false;
  std::vector<int64_t> shape;  // outermost-first, with the rank as written
};

class DeclaredTensors {
 public:
  // Parses `value` if `key` is one of these options (in any case); otherwise returns false.
  // DIMENSION_SYNTAX and TYPE_SYNTAX for invalid texts.
  Result<bool> take(std::string_view key, std::string_view value);
  const std::vector<DeclaredTensor>& inputs() const noexcept { return inputs_; }
  const std::vector<DeclaredTensor>& outputs() const noexcept { return outputs_; }

 private:
  std::vector<DeclaredTensor> inputs_, outputs_;
};

// Formats dimensions innermost first, as in caps: "3:224:224:1".
std::string dimension_text(const std::vector<int64_t>& shape);
// The type with this name; empty when there is none.
std::optional<uint32_t> parse_type(std::string_view name);

}  // namespace weir::engine
