// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/ledger_stats.hpp"

#include <string>

namespace weir::gst {

GstStructure* to_structure(const LedgerSnapshot& s) {
  GstStructure* out = gst_structure_new(
      "stats", "received", G_TYPE_UINT64, s.received, "consumed", G_TYPE_UINT64, s.consumed, "held",
      G_TYPE_UINT64, s.held(), "pushed", G_TYPE_UINT64, s.pushed, "dropped", G_TYPE_UINT64,
      s.dropped_total(), "bytes-copied", G_TYPE_UINT64, s.bytes_copied, "integer-divisions-by-zero",
      G_TYPE_UINT64, s.integer_divisions_by_zero, nullptr);
  for (size_t i = 0; i < kDropReasons; ++i) {
    const std::string name = "dropped-" + std::string(to_string(static_cast<DropReason>(i)));
    gst_structure_set(out, name.c_str(), G_TYPE_UINT64, s.dropped[i], nullptr);
  }
  return out;
}

}  // namespace weir::gst
