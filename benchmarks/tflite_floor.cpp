// TensorFlow Lite with XNNPACK in a plain loop, with the input copy that the library's API
// requires. WEIR_ENGINE_LIBRARY: the library that the module loads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>
#include <tensorflow/lite/c/c_api.h>
#include <tensorflow/lite/c/common.h>

#include <stdexcept>

#include "engine_floor.hpp"

namespace weir::bench {
namespace {

template <class Function>
Function function(const char* name) {
  static void* const library = dlopen(WEIR_ENGINE_LIBRARY, RTLD_NOW);
  const auto found = reinterpret_cast<Function>(library ? dlsym(library, name) : nullptr);
  if (!found) throw std::runtime_error(dlerror());
  return found;
}
#define LITE(name) function<decltype(&name)>(#name)

class TfliteFloor : public EngineFloor {
 public:
  TfliteFloor(const std::string& model, const std::vector<int64_t>& shape, bool uint8) {
    size_t bytes = uint8 ? 1 : sizeof(float);
    for (const int64_t extent : shape) bytes *= static_cast<size_t>(extent);
    input_.resize(bytes);
    auto* options = LITE(TfLiteInterpreterOptionsCreate)();
    LITE(TfLiteInterpreterOptionsSetNumThreads)(options, 1);
    interpreter_ =
        LITE(TfLiteInterpreterCreate)(LITE(TfLiteModelCreateFromFile)(model.c_str()), options);
    LITE(TfLiteInterpreterOptionsDelete)(options);
    // int32 threads, uint32 flags (1: int8), and members that stay 0.
    struct {
      int32_t threads = 1;
      uint32_t flags = 1;
      void* rest[16] = {};
    } const delegate;
    const auto made = function<TfLiteDelegate* (*)(const void*)>("TfLiteXNNPackDelegateCreate");
    function<TfLiteStatus (*)(TfLiteInterpreter*, TfLiteDelegate*)>(
        "TfLiteInterpreterModifyGraphWithDelegate")(interpreter_, made(&delegate));
    if (LITE(TfLiteInterpreterAllocateTensors)(interpreter_) != kTfLiteOk)
      throw std::runtime_error("TensorFlow Lite does not take the model");
    to_ = LITE(TfLiteInterpreterGetInputTensor)(interpreter_, 0);
  }
  void run(int frames) override {
    for (int i = 0; i < frames; ++i)
      if (copy_(to_, input_.data(), input_.size()) != kTfLiteOk ||
          invoke_(interpreter_) != kTfLiteOk)
        throw std::runtime_error("TensorFlow Lite failed");
  }

 private:
  std::vector<uint8_t> input_;
  TfLiteInterpreter* interpreter_ = nullptr;
  TfLiteTensor* to_ = nullptr;
  decltype(&TfLiteTensorCopyFromBuffer) copy_ = LITE(TfLiteTensorCopyFromBuffer);
  decltype(&TfLiteInterpreterInvoke) invoke_ = LITE(TfLiteInterpreterInvoke);
};

}  // namespace

std::unique_ptr<EngineFloor> make_floor(const std::string& models,
                                        const std::vector<int64_t>& shape, bool uint8) {
  return std::make_unique<TfliteFloor>(models, shape, uint8);
}

}  // namespace weir::bench
