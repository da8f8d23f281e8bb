// ONNX Runtime's C API: the library opened once, its objects owned, its errors turned into values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <onnxruntime_c_api.h>

#include <memory>
#include <string>

#include "engine_library.hpp"

namespace weir::engine {

// One for the process; ends after the last model.
class OrtRuntime {
 public:
  // Opens the library on first use. ENGINE_NOT_INSTALLED as EngineLibrary says.
  static Result<std::shared_ptr<const OrtRuntime>> instance();
  ~OrtRuntime();
  OrtRuntime(const OrtRuntime&) = delete;
  OrtRuntime& operator=(const OrtRuntime&) = delete;

  const OrtApi& api() const noexcept { return *api_; }
  OrtEnv* environment() const noexcept { return environment_; }
  const OrtMemoryInfo* host_memory() const noexcept { return memory_; }
  OrtAllocator* allocator() const noexcept { return allocator_; }  // the library's default one
  const std::string& version() const noexcept { return version_; }
  const std::string& path() const noexcept { return path_; }

 private:
  OrtRuntime() = default;
  static Result<std::shared_ptr<const OrtRuntime>> load();

  const OrtApi* api_ = nullptr;
  OrtEnv* environment_ = nullptr;    // released by the destructor
  OrtMemoryInfo* memory_ = nullptr;  // released by the destructor
  OrtAllocator* allocator_ = nullptr;
  std::string version_, path_;
};

// The message of a status, which is released; "" = success.
struct OrtFailure {
  OrtErrorCode code = ORT_OK;
  std::string text;
  explicit operator bool() const noexcept { return code != ORT_OK; }
};
OrtFailure take(const OrtApi& api, OrtStatus* status);
// ONNX Runtime has no code for it: memory, or a thread, that the system refused.
bool is_out_of_memory(const OrtFailure& failure);

// While it lives: what ONNX Runtime warns of on this thread from one place of its code, for each
// weight of a model say, is logged once, with the number of the others behind it.
class FoldedWarnings {
 public:
  FoldedWarnings();
  ~FoldedWarnings();
  FoldedWarnings(const FoldedWarnings&) = delete;
  FoldedWarnings& operator=(const FoldedWarnings&) = delete;

  // Whether the warning is another one from the place of the last.
  bool folds(const char* place);

 private:
  void tell();

  FoldedWarnings* outer_;
  std::string place_;
  size_t repeated_ = 0;
};

// unique_ptr of an ORT object; the deleter knows the API it came from.
template <class T>
using OrtOwner = std::unique_ptr<T, void(ORT_API_CALL*)(T*)>;

}  // namespace weir::engine
