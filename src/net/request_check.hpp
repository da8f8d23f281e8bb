// Whether a request fits the model that it names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <vector>

#include "net/oip_service_messages.hpp"

namespace weir::net {

// For each input of the model, the index of its tensor in the request. Names decide; a tensor may
// have more or fewer outer dimensions of 1, and BOOL is accepted for UINT8.
// SPEC_MISMATCH with both sides, before anything is copied.
Result<std::vector<size_t>> match_inputs(const InferRequest& request, const ModelMetadata& model);
// The indices of the outputs that the request asks for, in its order; all if it asks for none.
// SPEC_MISMATCH for a name that the model does not have.
Result<std::vector<size_t>> match_outputs(const InferRequest& request, const ModelMetadata& model);

}  // namespace weir::net
