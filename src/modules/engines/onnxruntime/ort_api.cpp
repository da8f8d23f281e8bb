// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_api.hpp"

#include <iostream>
#include <mutex>
#include <streambuf>
#include <utility>

#include "environment_variable.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

weir_log_level to_level(OrtLoggingLevel severity) {
  switch (severity) {
    case ORT_LOGGING_LEVEL_FATAL:
    case ORT_LOGGING_LEVEL_ERROR:
      return WEIR_LOG_ERROR;
    case ORT_LOGGING_LEVEL_WARNING:
      return WEIR_LOG_WARNING;
    case ORT_LOGGING_LEVEL_INFO:
      return WEIR_LOG_INFO;
    default:
      return WEIR_LOG_DEBUG;
  }
}

thread_local FoldedWarnings* folded = nullptr;

// Errors are also returned as values, in more detail, so the log repeats them at INFO for
// debugging.
void ORT_API_CALL forward_log(void*, OrtLoggingLevel severity, const char*, const char*,
                              const char* place, const char* message) {
  const auto level = to_level(severity);
  if (level == WEIR_LOG_WARNING && folded && folded->folds(place ? place : "")) return;
  log(level == WEIR_LOG_ERROR ? WEIR_LOG_INFO : level, message ? message : "");
}

// From 1.29 on, the vendor's builds report to Microsoft which models a process opens, and store a
// machine number in the user's cache, as soon as an OrtEnv exists: too early for
// OrtApi::DisableTelemetryEvents. They read this variable when the first OrtEnv is created. A value
// that the user has set is kept.
void disable_telemetry() {
  add_environment_variable("ORT_DISABLE_TELEMETRY=1");
}

// ONNX Runtime of Debian 13 and the libonnx that it needs both register all operators, and the
// second of them prints each as an error to std::cerr when the process makes its first session: 567
// lines. That session is made here, of a model that passes one number through, and what it prints
// is left out. libonnx writes past the logger and has no setting, so std::cerr itself is silenced,
// although other threads may print meanwhile.
void register_operators(const OrtApi& api, const OrtEnv* environment) {
  static constexpr char kModel[] =
      "\010\010\072\067"
      "\012\020\012\001x\022\001y\042\010Identity\022\001g"
      "Z\017\012\001x\022\012\012\010\010\001\022\004\012\002\010\001"
      "b\017\012\001y\022\012\012\010\010\001\022\004\012\002\010\001"
      "B\002\020\015";
  OrtSessionOptions* options = nullptr;
  OrtSession* session = nullptr;
  std::streambuf* errors = std::cerr.rdbuf(nullptr);
  if (!take(api, api.CreateSessionOptions(&options)))
    take(api,
         api.CreateSessionFromArray(environment, kModel, sizeof kModel - 1, options, &session));
  std::cerr.rdbuf(errors);
  if (session) api.ReleaseSession(session);
  if (options) api.ReleaseSessionOptions(options);
}

}  // namespace

FoldedWarnings::FoldedWarnings() : outer_(std::exchange(folded, this)) {}

FoldedWarnings::~FoldedWarnings() {
  folded = outer_;
  report_repeated();
}

bool FoldedWarnings::folds(const char* place) {
  if (!place_.empty() && place_ == place) {
    ++repeated_;
    return true;
  }
  report_repeated();
  place_ = place;
  return false;
}

void FoldedWarnings::report_repeated() {
  if (repeated_ > 0)
    log(WEIR_LOG_WARNING, "and " + std::to_string(repeated_) + " more of this kind");
  repeated_ = 0;
}

OrtFailure take(const OrtApi& api, OrtStatus* status) {
  if (!status) return {};
  OrtFailure failure{api.GetErrorCode(status), api.GetErrorMessage(status)};
  if (failure.code == ORT_OK) failure.code = ORT_FAIL;
  api.ReleaseStatus(status);
  return failure;
}

bool is_out_of_memory(const OrtFailure& failure) {
  for (const char* phrase : {"Cannot allocate memory", "pthread_create failed", "bad_alloc",
                             "bad allocation", "Failed to allocate memory"})
    if (failure.text.find(phrase) != std::string::npos) return true;
  return false;
}

Result<std::shared_ptr<const OrtRuntime>> OrtRuntime::instance() {
  static std::mutex mutex;  // guards `runtime`
  // Never released: when the process ends, static objects of the library may be gone already.
  static auto& runtime = *new std::shared_ptr<const OrtRuntime>;
  const std::lock_guard lock(mutex);
  if (runtime) return runtime;
  auto loaded = load();  // retries a missing library: it may have been installed since
  if (loaded) runtime = *loaded;
  return loaded;
}

Result<std::shared_ptr<const OrtRuntime>> OrtRuntime::load() {
  auto library = EngineLibrary::open("onnxruntime", "ONNX Runtime",
                                     {"libonnxruntime.so.1", "libonnxruntime.so"}, WEIR_ORT_SONAME);
  if (!library) return library.error();
  const auto unusable = [&](const std::string& offered) {
    return Error{.code = Code::ENGINE_NOT_INSTALLED,
                 .what = "the library of ONNX Runtime cannot be used",
                 .offered = library->path() + ": " + offered,
                 .needed = "ONNX Runtime with C API " + std::to_string(ORT_API_VERSION),
                 .fix = library->install_command()};
  };
  using GetBase = const OrtApiBase*(ORT_API_CALL*)();
  const auto get_base = library->symbol<GetBase>("OrtGetApiBase");
  if (!get_base) return unusable("no symbol OrtGetApiBase");
  const OrtApiBase* base = get_base();
  std::shared_ptr<OrtRuntime> out(new OrtRuntime);
  out->version_ = base->GetVersionString();
  out->path_ = library->path();
  const OrtApi* api = base->GetApi(ORT_API_VERSION);
  if (!api) return unusable("version " + out->version_ + " is too old");
  out->api_ = api;
  disable_telemetry();
  if (auto bad =
          take(*api, api->CreateEnvWithCustomLogger(forward_log, nullptr, ORT_LOGGING_LEVEL_WARNING,
                                                    "weir", &out->environment_)))
    return unusable(bad.text);
  if (library->is_of_system()) register_operators(*api, out->environment_);
  if (auto bad = take(
          *api, api->CreateCpuMemoryInfo(OrtDeviceAllocator, OrtMemTypeDefault, &out->memory_)))
    return unusable(bad.text);
  if (auto bad = take(*api, api->GetAllocatorWithDefaultOptions(&out->allocator_)))
    return unusable(bad.text);
  return std::shared_ptr<const OrtRuntime>(std::move(out));
}

OrtRuntime::~OrtRuntime() {
  if (memory_) api_->ReleaseMemoryInfo(memory_);
  if (environment_) api_->ReleaseEnv(environment_);
}

}  // namespace weir::engine
