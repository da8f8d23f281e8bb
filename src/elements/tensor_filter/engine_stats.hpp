// What an engine counts on its own, for the property "stats" of tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/infer/model/model.hpp"

namespace weir {

// Adds the counts of the engine, and `servers`, an array with a structure for each server that the
// model is on: nothing if the engine reports none.
void add_engine_stats(const infer::Model& model, GstStructure* stats);

}  // namespace weir
