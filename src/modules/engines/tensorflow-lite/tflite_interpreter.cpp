// Creates an interpreter, with or without the delegate.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_interpreter.hpp"

#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <string_view>
#include <utility>

#include "tensor_check.hpp"
#include "thread_limit.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

bool mentions(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words)
    if (text.find(word) != std::string::npos) return true;
  return false;
}

Error load_error(const std::string& reported_errors) {
  if (mentions(reported_errors,
               {"unresolved custom op", "Didn't find op", "Op builtin_code out of range",
                "Registration failed", "unsupported data type", "Flex ops"}))
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the model needs something that TensorFlow Lite lacks",
                 .offered = reported_errors,
                 .needed = "builtin operators of TensorFlow Lite 2.9",
                 .fix = "convert the model with builtin operators only"};
  return Error{.code = Code::MODEL_INVALID,
               .what = "TensorFlow Lite cannot load the model",
               .offered = reported_errors.empty() ? "no reason given" : reported_errors,
               .needed = "a model that it can run",
               .fix = "download or export the model again, then check it with weir inspect MODEL"};
}

#ifdef __GLIBC__
ssize_t collect(void* text, const char* more, size_t size) {
  static_cast<std::string*>(text)->append(more, size);
  return static_cast<ssize_t>(size);
}

// The library prints a line to stderr when it makes its first delegate, and no setting prevents it.
// What other threads print meanwhile is passed on.
TfLiteDelegate* create_delegate(const TfliteApi& api, const XnnpackOptions& options) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  static std::string printed;
  static FILE* const collecting =  // never closed: another thread may be using it
      fopencookie(&printed, "w",
                  {.read = nullptr, .write = collect, .seek = nullptr, .close = nullptr});
  if (!collecting) return api.xnnpack_create(&options);
  FILE* const before = std::exchange(stderr, collecting);
  TfLiteDelegate* const delegate = api.xnnpack_create(&options);
  stderr = before;
  std::fflush(collecting);
  constexpr std::string_view kLine = "INFO: Created TensorFlow Lite XNNPACK delegate for CPU.";
  if (const size_t at = printed.find(kLine); at != std::string::npos) {
    log(WEIR_LOG_INFO, std::string(kLine));
    printed.erase(at, kLine.size() + (at + kLine.size() < printed.size() ? 1 : 0));
  }
  std::fputs(printed.c_str(), stderr);
  printed.clear();
  return delegate;
}
#else
TfLiteDelegate* create_delegate(const TfliteApi& api, const XnnpackOptions& options) {
  return api.xnnpack_create(&options);
}
#endif

}  // namespace

TfliteInterpreter::TfliteInterpreter(const TfliteApi& api)
    : api_(api),
      delegate_(nullptr, api.xnnpack_delete),
      interpreter_(nullptr, api.interpreter_delete) {}

void TfliteInterpreter::report(void* self, const char* format, va_list arguments) {
  char line[512];
  if (std::vsnprintf(line, sizeof line, format, arguments) < 0) return;
  auto& reported_errors = static_cast<TfliteInterpreter*>(self)->reported_errors_;
  if (reported_errors.size() < 4096)
    reported_errors += (reported_errors.empty() ? "" : "; ") + std::string(line);
}

Result<std::unique_ptr<TfliteInterpreter>> TfliteInterpreter::create(
    const TfliteApi& api, const TfLiteModel* model, const TfliteOptions& options,
    std::span<const weir_tensor_info> shapes) {
  const bool delegate =
      options.xnnpack == true && api.modify_graph && api.xnnpack_create && api.xnnpack_delete;
  std::unique_ptr<TfliteInterpreter> out(new TfliteInterpreter(api));
  if (delegate) {
    const auto status = out->build(model, options, true, shapes);
    if (status) return out;
    if (status.error().code == Code::OUT_OF_MEMORY) return status.error();
    log(WEIR_LOG_INFO, "XNNPACK does not accept this model: " + out->reported_errors_);
    out.reset(new TfliteInterpreter(api));
  }
  if (auto status = out->build(model, options, false, shapes); !status) return status.error();
  return out;
}

Status TfliteInterpreter::build(const TfLiteModel* model, const TfliteOptions& options,
                                bool delegate, std::span<const weir_tensor_info> shapes) {
  const std::unique_ptr<TfLiteInterpreterOptions, void (*)(TfLiteInterpreterOptions*)> settings(
      api_.options_create(), api_.options_delete);
  if (!settings) return load_error("no memory");
  api_.options_set_num_threads(settings.get(), options.threads);
  api_.options_set_error_reporter(settings.get(), report, this);
  interpreter_.reset(api_.interpreter_create(model, settings.get()));
  if (!interpreter_) return load_error(reported_errors_);
  if (auto status = resize(shapes); !status) return status;
  if (delegate && options.threads > 1)
    if (auto status = check_thread_limit(options.threads - 1); !status) return status;
  if (delegate && !delegate_graph(options.threads)) return load_error(reported_errors_);
  if (api_.allocate_tensors(interpreter_.get()) == kTfLiteOk) return ok();
  Error error = load_error(reported_errors_);
  if (!shapes.empty()) {
    error.code = Code::SPEC_MISMATCH;
    error.what = "the model does not work with inputs of these shapes";
    error.offered = describe(shapes) + ": " + reported_errors_;
    error.needed = "shapes that all its layers accept";
    error.fix.clear();
  }
  return error;
}

Status TfliteInterpreter::resize(std::span<const weir_tensor_info> shapes) {
  for (size_t i = 0; i < shapes.size(); ++i) {
    const auto& info = shapes[i];
    std::vector<int> extents(info.shape, info.shape + info.rank);
    if (api_.resize_input(interpreter_.get(), static_cast<int32_t>(i), extents.data(),
                          static_cast<int32_t>(extents.size())) != kTfLiteOk)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the model does not accept an input of this shape",
                   .offered = describe(info) + ": " + reported_errors_};
  }
  return ok();
}

bool TfliteInterpreter::delegate_graph(int threads) {
  XnnpackOptions options;
  options.num_threads = threads;
  options.flags = kXnnpackSignedInt8;
  delegate_.reset(create_delegate(api_, options));
  return delegate_ && api_.modify_graph(interpreter_.get(), delegate_.get()) == kTfLiteOk;
}

size_t TfliteInterpreter::inputs() const {
  return static_cast<size_t>(api_.input_count(interpreter_.get()));
}
size_t TfliteInterpreter::outputs() const {
  return static_cast<size_t>(api_.output_count(interpreter_.get()));
}
TfLiteTensor* TfliteInterpreter::input(size_t index) const {
  return api_.input(interpreter_.get(), static_cast<int32_t>(index));
}
const TfLiteTensor* TfliteInterpreter::output(size_t index) const {
  return api_.output(interpreter_.get(), static_cast<int32_t>(index));
}

Status TfliteInterpreter::invoke() {
  reported_errors_.clear();
  if (api_.invoke(interpreter_.get()) == kTfLiteOk) return ok();
  return Error{.code = Code::INVOKE_FAILED,
               .what = "TensorFlow Lite failed on a frame",
               .offered = reported_errors_};
}

void TfliteInterpreter::reset_state() {
  if (api_.reset_variables) api_.reset_variables(interpreter_.get());
}

}  // namespace weir::engine
