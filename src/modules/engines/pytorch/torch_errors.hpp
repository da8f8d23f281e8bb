// Shortens libtorch's exceptions, which fill pages, to one line with the operator that failed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::engine {

// "RuntimeError: mat1 and mat2 shapes cannot be multiplied (1x4 and 5x2) (in torch.linear)".
std::string torch_reason(std::string_view text);
// The error when loading a file fails.
Error torch_load_error(const std::string& model, std::string_view text);
// The error when running fails.
Error torch_run_error(std::string_view text);

}  // namespace weir::engine
