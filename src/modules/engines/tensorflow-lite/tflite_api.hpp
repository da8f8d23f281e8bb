// TfliteApi: the C API of TensorFlow Lite, loaded at run time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <tensorflow/lite/c/c_api.h>
#include <tensorflow/lite/c/common.h>

#include <memory>
#include <string>

#include "engine_library.hpp"

namespace weir::engine {

// The structure of tensorflow/lite/delegates/xnnpack/xnnpack_delegate.h, which no package contains.
// Members after the first ones differ between versions and stay zero.
struct XnnpackOptions {
  int32_t num_threads = 0;
  uint32_t flags = 0;
  void* reserved[16] = {};
};
constexpr uint32_t kXnnpackSignedInt8 = 1;  // TFLITE_XNNPACK_DELEGATE_FLAG_QS8

// The functions that the engine calls; one table per process.
struct TfliteApi {
  // Loads the library on first use. ENGINE_NOT_INSTALLED as for EngineLibrary::open().
  static Result<const TfliteApi*> instance();

  decltype(&TfLiteVersion) version;
  decltype(&TfLiteModelCreate) model_create;
  decltype(&TfLiteModelDelete) model_delete;
  decltype(&TfLiteInterpreterOptionsCreate) options_create;
  decltype(&TfLiteInterpreterOptionsDelete) options_delete;
  decltype(&TfLiteInterpreterOptionsSetNumThreads) options_set_num_threads;
  decltype(&TfLiteInterpreterOptionsSetErrorReporter) options_set_error_reporter;
  decltype(&TfLiteInterpreterCreate) interpreter_create;
  decltype(&TfLiteInterpreterDelete) interpreter_delete;
  decltype(&TfLiteInterpreterGetInputTensorCount) input_count;
  decltype(&TfLiteInterpreterGetInputTensor) input;
  decltype(&TfLiteInterpreterGetOutputTensorCount) output_count;
  decltype(&TfLiteInterpreterGetOutputTensor) output;
  decltype(&TfLiteInterpreterResizeInputTensor) resize_input;
  decltype(&TfLiteInterpreterAllocateTensors) allocate_tensors;
  decltype(&TfLiteInterpreterInvoke) invoke;
  decltype(&TfLiteTensorCopyFromBuffer) copy_from;
  decltype(&TfLiteTensorQuantizationParams) quantization;
  // From c_api_experimental.h; null if the library lacks them.
  TfLiteStatus (*modify_graph)(const TfLiteInterpreter*, TfLiteDelegate*);
  TfLiteStatus (*reset_variables)(TfLiteInterpreter*);
  TfLiteDelegate* (*xnnpack_create)(const XnnpackOptions*);
  void (*xnnpack_delete)(TfLiteDelegate*);

  std::string path, version_text;

 private:
  static Result<std::unique_ptr<const TfliteApi>> load();
};

}  // namespace weir::engine
