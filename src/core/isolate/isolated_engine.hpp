// The engine that runs any engine in a process of its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "core/infer/model.hpp"
#include "core/isolate/isolation.hpp"
#include "core/isolate/shared_arena.hpp"

namespace weir::isolate {

// A table like any engine's. Each session is a process; there may be as many as wanted, whatever
// the engine itself allows. open() needs OpenOptions::host_context: an Isolation. It takes inputs
// at any address: what the engine needs more is seen to in memory of arena_of().
const weir_engine& isolated_engine() noexcept;

// Of a model that isolated_engine() opened; null (or "") for others.
std::shared_ptr<SharedArena> arena_of(const infer::Model& model);
std::shared_ptr<Monitor> monitor_of(const infer::Model& model);
// The name of the engine that works in the process.
std::string engine_in(const infer::Model& model);

}  // namespace weir::isolate
