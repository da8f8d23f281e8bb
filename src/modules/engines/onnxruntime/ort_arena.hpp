// OrtArena: the memory arena that all sessions of the process share for computation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "onnxruntime/ort_api.hpp"

namespace weir::engine {

// ONNX Runtime gives each session its own arena, which keeps what its largest invoke needed. With a
// shared arena, models that run in turn use only the memory of the largest. Sessions created while
// it exists use it if they set kSharedArenaKey; these sessions and their output values may outlive
// it. Thread-safe.
class OrtArena {
 public:
  // Returns the existing arena or creates one. If that fails, sessions use their own.
  static std::shared_ptr<const OrtArena> shared(std::shared_ptr<const OrtRuntime> runtime);
  ~OrtArena();  // returns memory that no session or value uses to the system
  OrtArena(const OrtArena&) = delete;
  OrtArena& operator=(const OrtArena&) = delete;

 private:
  explicit OrtArena(std::shared_ptr<const OrtRuntime> runtime);
  std::shared_ptr<const OrtRuntime> runtime_;
  OrtOwner<OrtMemoryInfo> memory_;
};

// From onnxruntime_session_options_config_keys.h. Weights stay out of the arena, so that closing a
// model frees them.
inline constexpr const char* kSharedArenaKey = "session.use_env_allocators";
inline constexpr const char* kWeightsApartKey = "session.use_device_allocator_for_initializers";

}  // namespace weir::engine
