// OrtArena: the memory that all sessions of the process take for what they compute.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "onnxruntime/ort_api.hpp"

namespace weir::engine {

// ONNX Runtime gives each session an arena of its own, which keeps what its largest invoke needed.
// With this one, models that run one after the other have the memory of the largest once. Sessions
// that are made while it lives use it when they are told to (kSharedArenaKey); they, and values
// that they gave away, may live longer. Thread-safe.
class OrtArena {
 public:
  // The one that lives, or a new one. Where there can be none, sessions have their own.
  static std::shared_ptr<const OrtArena> shared(std::shared_ptr<const OrtRuntime> runtime);
  ~OrtArena();  // what no session and no value holds any more is given back to the system
  OrtArena(const OrtArena&) = delete;
  OrtArena& operator=(const OrtArena&) = delete;

 private:
  explicit OrtArena(std::shared_ptr<const OrtRuntime> runtime);
  std::shared_ptr<const OrtRuntime> runtime_;
  OrtOwner<OrtMemoryInfo> memory_;
};

// Of onnxruntime_session_options_config_keys.h. Weights stay out of the arena: a model that is
// closed frees them.
inline constexpr const char* kSharedArenaKey = "session.use_env_allocators";
inline constexpr const char* kWeightsApartKey = "session.use_device_allocator_for_initializers";

}  // namespace weir::engine
