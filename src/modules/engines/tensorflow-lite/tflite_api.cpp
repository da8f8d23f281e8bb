// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_api.hpp"

#include <charconv>
#include <mutex>

#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

// Whether "2.9.0" is 2.9 or a later 2.x. Earlier versions have another layout of XNNPACK's options.
bool is_recent(std::string_view version) {
  int numbers[2]{};
  const char* end = version.data() + version.size();
  const auto major = std::from_chars(version.data(), end, numbers[0]);
  if (major.ec == std::errc() && major.ptr != end && *major.ptr == '.')
    std::from_chars(major.ptr + 1, end, numbers[1]);
  return numbers[0] == 2 && numbers[1] >= 9;
}

Error not_usable(const EngineLibrary& library, const std::string& offered) {
  return {.code = Code::ENGINE_NOT_INSTALLED,
          .what = "the library of TensorFlow Lite cannot be used",
          .offered = library.path() + ": " + offered,
          .needed = "the C library of TensorFlow Lite 2.9 or a later 2.x",
          .fix = library.install_command()};
}

}  // namespace

Result<const TfliteApi*> TfliteApi::instance() {
  static std::mutex mutex;  // guards `api`
  static std::unique_ptr<const TfliteApi> api;
  const std::lock_guard lock(mutex);
  if (api) return api.get();
  auto loaded = load();  // retries a missing library: it may have been installed since
  if (!loaded) return loaded.error();
  api = *std::move(loaded);
  return api.get();
}

Result<std::unique_ptr<const TfliteApi>> TfliteApi::load() {
  const auto library =
      EngineLibrary::open("tensorflow-lite", "TensorFlow Lite", {"libtensorflowlite_c.so"});
  if (!library) return library.error();
  auto api = std::make_unique<TfliteApi>();
  std::string missing;
  const auto want = [&](auto* function, const char* name) {
    *function = library->symbol<std::remove_pointer_t<decltype(function)>>(name);
    if (!*function && missing.empty()) missing = name;
  };
  want(&api->version, "TfLiteVersion");
  want(&api->model_create, "TfLiteModelCreate");
  want(&api->model_delete, "TfLiteModelDelete");
  want(&api->options_create, "TfLiteInterpreterOptionsCreate");
  want(&api->options_delete, "TfLiteInterpreterOptionsDelete");
  want(&api->options_set_num_threads, "TfLiteInterpreterOptionsSetNumThreads");
  want(&api->options_set_error_reporter, "TfLiteInterpreterOptionsSetErrorReporter");
  want(&api->interpreter_create, "TfLiteInterpreterCreate");
  want(&api->interpreter_delete, "TfLiteInterpreterDelete");
  want(&api->input_count, "TfLiteInterpreterGetInputTensorCount");
  want(&api->input, "TfLiteInterpreterGetInputTensor");
  want(&api->output_count, "TfLiteInterpreterGetOutputTensorCount");
  want(&api->output, "TfLiteInterpreterGetOutputTensor");
  want(&api->resize_input, "TfLiteInterpreterResizeInputTensor");
  want(&api->allocate_tensors, "TfLiteInterpreterAllocateTensors");
  want(&api->invoke, "TfLiteInterpreterInvoke");
  want(&api->copy_from, "TfLiteTensorCopyFromBuffer");
  want(&api->quantization, "TfLiteTensorQuantizationParams");
  if (!missing.empty()) return not_usable(*library, "no symbol " + missing);
  if (!is_recent(text_or_empty(api->version())))
    return not_usable(
        *library, "version " + std::string(text_or_empty(api->version())) + " is not supported");
  want(&api->modify_graph, "TfLiteInterpreterModifyGraphWithDelegate");
  want(&api->reset_variables, "TfLiteInterpreterResetVariableTensors");
  want(&api->xnnpack_create, "TfLiteXNNPackDelegateCreate");
  want(&api->xnnpack_delete, "TfLiteXNNPackDelegateDelete");
  api->path = library->path();
  api->version_text = api->version();
  return std::unique_ptr<const TfliteApi>(std::move(api));
}

}  // namespace weir::engine
