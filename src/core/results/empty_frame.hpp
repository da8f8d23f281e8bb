// The frame without results of any stream of results: rows have one row of zeros.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/results/results_writer.hpp"
#include "core/tensor/result_roles.hpp"

namespace weir::results {

// Writes one memory for each tensor, with its header. False if the columns of a role are not valid;
// then nothing is reserved.
bool write_empty(const ResultRoles& roles, const Reserve& reserve);

}  // namespace weir::results
