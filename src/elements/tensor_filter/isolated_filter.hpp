// What tensor_filter does for isolate=process besides opening another engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>

#include "core/infer/model.hpp"
#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// The context for isolate::isolated_engine(). `automatic`: the engine is found by the model's
// files.
std::shared_ptr<isolate::Isolation> isolation_of(const FilterSettings& settings, bool automatic,
                                                 std::shared_ptr<isolate::Monitor> monitor);

// Null unless isolate=process. Ends of workers become warnings of the element as long as it lives;
// with on-crash=error they are errors, which somebody else posts.
std::shared_ptr<isolate::Monitor> make_monitor(const FilterSettings& settings, GstElement* element);

// INFO: how the worker process is confined. WARNING: what of it the kernel refused.
void log_confinement(const isolate::Monitor& monitor, GstElement* element);

void add_worker_stats(const isolate::Monitor& monitor, GstStructure* stats);

}  // namespace weir
