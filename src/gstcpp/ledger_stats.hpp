// The ledger as a GstStructure, for the property "stats".
#pragma once
#include <gst/gst.h>

#include "core/ledger/ledger.hpp"

namespace weir::gst {

// "stats": received, consumed, held, pushed, dropped, dropped-policy, ... (all uint64). Caller
// owns.
GstStructure* to_structure(const LedgerSnapshot& snapshot);

}  // namespace weir::gst
