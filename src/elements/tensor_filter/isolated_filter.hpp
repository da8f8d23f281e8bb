// The worker process of a tensor_filter with isolate=process: its settings, warnings and stats.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>

#include "core/infer/model/model.hpp"
#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// The context for isolate::isolated_engine(). `automatic`: the engine is chosen by the model files.
std::shared_ptr<isolate::Isolation> isolation_of(const FilterSettings& settings, bool automatic,
                                                 std::shared_ptr<isolate::Monitor> monitor);

// Null unless isolate=process. While the element exists, it posts a warning when a worker ends.
// With on-crash=error that is an error, which the flow posts.
std::shared_ptr<isolate::Monitor> make_monitor(const FilterSettings& settings, GstElement* element);

// Logs how the worker process is confined, and a warning for what the kernel does not support.
void log_confinement(const isolate::Monitor& monitor, GstElement* element);

void add_worker_stats(const isolate::Monitor& monitor, GstStructure* stats);

}  // namespace weir
