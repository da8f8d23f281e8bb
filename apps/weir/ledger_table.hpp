// The ledgers of Weir's elements in a pipeline: where every frame went.
#pragma once
#include <gst/gst.h>

#include <string>

#include "report.hpp"

namespace weir::app {

// [{"name": ..., "element": ..., "stats": {...}}], in the order of the stream's way.
Json ledgers(GstElement* pipeline);
// The same for people; "" when there is none.
std::string ledger_table(const Json& ledgers);

}  // namespace weir::app
