// Tells what an element waits for, by its class and properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/trace/graph.hpp"

namespace weir::tracer {

// Reads properties, so no lock may be held. Never for null.
trace::Waits waits_of(GstElement* element);

}  // namespace weir::tracer
