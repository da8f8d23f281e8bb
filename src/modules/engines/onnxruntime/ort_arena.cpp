// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_arena.hpp"

#include <mutex>

namespace weir::engine {

std::shared_ptr<const OrtArena> OrtArena::shared(std::shared_ptr<const OrtRuntime> runtime) {
  static std::mutex mutex;  // guards the weak reference to the current arena
  static std::weak_ptr<const OrtArena> living;
  const std::lock_guard lock(mutex);
  auto arena = living.lock();
  if (!arena) {
    arena.reset(new OrtArena(std::move(runtime)));
    living = arena;
  }
  return arena;
}

OrtArena::OrtArena(std::shared_ptr<const OrtRuntime> runtime)
    : runtime_(std::move(runtime)), memory_(nullptr, runtime_->api().ReleaseMemoryInfo) {
  const OrtApi& api = runtime_->api();
  OrtMemoryInfo* memory = nullptr;
  if (take(api, api.CreateCpuMemoryInfo(OrtArenaAllocator, OrtMemTypeDefault, &memory))) return;
  memory_.reset(memory);  // must exist while the arena is registered
  if (take(api, api.CreateAndRegisterAllocator(runtime_->environment(), memory, nullptr)))
    memory_.reset();
}

OrtArena::~OrtArena() {
  const OrtApi& api = runtime_->api();
  if (memory_) take(api, api.UnregisterAllocator(runtime_->environment(), memory_.get()));
}

}  // namespace weir::engine
