// Reads the ledgers of Weir's elements in a pipeline: the fate of every frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "report.hpp"

namespace weir::app {

// [{"name": ..., "element": ..., "stats": {...}}], in stream order.
Json ledgers(GstElement* pipeline);
// The same as text; "" when there is none.
// The servers that filters sent requests to, below their headings; empty if there is none.
std::vector<std::vector<std::string>> server_rows(const Json& ledgers);
// The times of the filters that ran a model; "" if there is none.
std::string filter_table(const Json& ledgers);
std::string ledger_table(const Json& ledgers);

}  // namespace weir::app
