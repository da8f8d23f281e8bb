// OrtRuntime: ONNX Runtime's C API, with owned objects and errors as values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <onnxruntime_c_api.h>

#include <memory>
#include <string>

#include "engine_library.hpp"

namespace weir::engine {

// One per process. It stays until the process ends.
class OrtRuntime {
 public:
  // Loads the library on first use. ENGINE_NOT_INSTALLED as for EngineLibrary::open().
  static Result<std::shared_ptr<const OrtRuntime>> instance();
  ~OrtRuntime();  // only of one that load() could not complete
  OrtRuntime(const OrtRuntime&) = delete;
  OrtRuntime& operator=(const OrtRuntime&) = delete;

  const OrtApi& api() const noexcept { return *api_; }
  OrtEnv* environment() const noexcept { return environment_; }
  const OrtMemoryInfo* host_memory() const noexcept { return memory_; }
  OrtAllocator* allocator() const noexcept {
    return allocator_;
  }  // the library's default allocator
  const std::string& version() const noexcept { return version_; }
  const std::string& path() const noexcept { return path_; }

 private:
  OrtRuntime() = default;
  static Result<std::shared_ptr<const OrtRuntime>> load();

  const OrtApi* api_ = nullptr;
  OrtEnv* environment_ = nullptr;
  OrtMemoryInfo* memory_ = nullptr;
  OrtAllocator* allocator_ = nullptr;
  std::string version_, path_;
};

// The code and message of a status, which is released; message "" = success.
struct OrtFailure {
  OrtErrorCode code = ORT_OK;
  std::string text;
  explicit operator bool() const noexcept { return code != ORT_OK; }
};
OrtFailure take(const OrtApi& api, OrtStatus* status);
// Whether the system refused memory or a thread, for which ONNX Runtime has no error code.
bool is_out_of_memory(const OrtFailure& failure);

// While it exists, repeated warnings of ONNX Runtime on this thread from one place in its code,
// such as one per weight of a model, are logged once, with the number of repetitions.
class FoldedWarnings {
 public:
  FoldedWarnings();
  ~FoldedWarnings();
  FoldedWarnings(const FoldedWarnings&) = delete;
  FoldedWarnings& operator=(const FoldedWarnings&) = delete;

  // Returns true if the warning comes from the same place as the previous one.
  bool folds(const char* place);

 private:
  void report_repeated();

  FoldedWarnings* outer_;
  std::string place_;
  size_t repeated_ = 0;
};

// unique_ptr for an ORT object; the deleter comes from the API that created it.
template <class T>
using OrtOwner = std::unique_ptr<T, void(ORT_API_CALL*)(T*)>;

}  // namespace weir::engine
