// BareLoop: ONNX Runtime's C API in a plain loop, the baseline for tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <dlfcn.h>
#include <onnxruntime_c_api.h>

#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace weir::bench {

// One session with one input and one output tensor, reused for each frame.
class BareLoop {
 public:
  // `batch`: the length of an open first axis.
  BareLoop(const char* library, const char* model, int threads, int64_t batch = 1) : batch_(batch) {
    void* handle = dlopen(library, RTLD_NOW);
    if (!handle) throw std::runtime_error(dlerror());
    const auto base = reinterpret_cast<const OrtApiBase* (*)()>(dlsym(handle, "OrtGetApiBase"));
    api_ = base()->GetApi(ORT_API_VERSION);
    if (!api_) throw std::runtime_error("the library is older than its header");
    setenv("ORT_DISABLE_TELEMETRY", "1",
           0);  // as the engine does: telemetry threads would be measured
    check(api_->CreateEnv(ORT_LOGGING_LEVEL_ERROR, "bare", &env_));
    OrtSessionOptions* options = nullptr;
    check(api_->CreateSessionOptions(&options));
    check(api_->SetIntraOpNumThreads(options, threads));
    check(api_->AddSessionConfigEntry(options, "session.intra_op.allow_spinning", "0"));
    check(api_->CreateSession(env_, model, options, &session_));
    api_->ReleaseSessionOptions(options);
    check(api_->GetAllocatorWithDefaultOptions(&allocator_));
    check(api_->SessionGetInputName(session_, 0, allocator_, &input_name_));
    check(api_->SessionGetOutputName(session_, 0, allocator_, &output_name_));
    input_ = tensor(true);
    output_ = tensor(false);
  }

  void run(int frames) {
    const OrtValue* in = input_;
    for (int i = 0; i < frames; ++i)
      check(api_->Run(session_, nullptr, &input_name_, &in, 1, &output_name_, 1, &output_));
  }
  // The input's caps: innermost dimension first.
  std::string caps() const {
    std::string dimension;
    for (auto at = shape_.rbegin(); at != shape_.rend(); ++at)
      dimension += (dimension.empty() ? "" : ":") + std::to_string(*at);
    return "other/tensor,type=float32,framerate=30/1,dimension=(string)" + dimension;
  }
  size_t input_bytes() const { return bytes_; }

 private:
  void check(OrtStatus* status) const {
    if (status) throw std::runtime_error(api_->GetErrorMessage(status));
  }
  OrtValue* tensor(bool input) {
    OrtTypeInfo* type = nullptr;
    check(input ? api_->SessionGetInputTypeInfo(session_, 0, &type)
                : api_->SessionGetOutputTypeInfo(session_, 0, &type));
    const OrtTensorTypeAndShapeInfo* info = nullptr;
    check(api_->CastTypeInfoToTensorInfo(type, &info));
    size_t rank = 0;
    check(api_->GetDimensionsCount(info, &rank));
    std::vector<int64_t> shape(rank);
    check(api_->GetDimensions(info, shape.data(), rank));
    api_->ReleaseTypeInfo(type);
    if (rank > 0 && shape[0] < 0) shape[0] = batch_;
    OrtValue* value = nullptr;
    check(api_->CreateTensorAsOrtValue(allocator_, shape.data(), rank,
                                       ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT, &value));
    size_t bytes = sizeof(float);
    for (const int64_t extent : shape) bytes *= static_cast<size_t>(extent);
    void* data = nullptr;
    check(api_->GetTensorMutableData(value, &data));
    std::memset(data, 0, bytes);
    if (input) shape_ = shape, bytes_ = bytes;
    return value;
  }

  int64_t batch_;
  const OrtApi* api_ = nullptr;
  OrtEnv* env_ = nullptr;
  OrtSession* session_ = nullptr;
  OrtAllocator* allocator_ = nullptr;
  char *input_name_ = nullptr, *output_name_ = nullptr;
  OrtValue *input_ = nullptr, *output_ = nullptr;
  std::vector<int64_t> shape_;
  size_t bytes_ = 0;
};

}  // namespace weir::bench
