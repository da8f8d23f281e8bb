// The ledger as a GstStructure, for the property "stats".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/ledger/ledger.hpp"

namespace weir::gst {

// "stats": received, consumed, held, pushed, dropped, dropped-policy, ... (all uint64). Transfer
// full.
GstStructure* to_structure(const LedgerSnapshot& snapshot);

}  // namespace weir::gst
