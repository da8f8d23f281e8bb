// An engine that runs models of any other engine in worker processes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "core/infer/model/model.hpp"
#include "core/isolate/isolation.hpp"
#include "core/isolate/shared_arena.hpp"
#include "core/isolate/worker_model_info.hpp"

namespace weir::isolate {

// Each session is a process, without the limit that the engine itself may have. open() requires
// OpenOptions::host_context to be an Isolation. It accepts inputs at any address; the requirements
// of the inner engine are met in memory of get_arena().
const weir_engine& isolated_engine() noexcept;

// For a model opened by isolated_engine(); null (or "") for others.
std::shared_ptr<SharedArena> get_arena(const infer::Model& model);
std::shared_ptr<Monitor> get_monitor(const infer::Model& model);
// The name of the engine inside the process, and the accelerator that it got.
std::string engine_in(const infer::Model& model);
AcceleratorChoice accelerator_in(const infer::Model& model);

}  // namespace weir::isolate
