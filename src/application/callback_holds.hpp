// The names of custom-easy filters and tensor_if conditions that pipelines use: while a pipeline
// exists, the callback of its name stays registered (docs/compatibility/app-api.md 8.7).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>
#include <utility>

namespace weir::application {

enum class CallbackKind { Filter, Condition };
using CallbackName = std::pair<CallbackKind, std::string>;

// Thread-safe. Each hold needs a release.
void hold_callback(const CallbackName& name);
void release_callback(const CallbackName& name);
// Runs `remove`, which takes the name, unless it is held; no hold begins meanwhile. Returns false
// if it is held.
bool remove_unless_held(const CallbackName& name, const std::function<void()>& remove);

}  // namespace weir::application
