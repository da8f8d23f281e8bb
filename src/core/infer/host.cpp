// The functions of weir_host and of the sink extension.
#include "core/infer/host.hpp"

#include <atomic>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace weir::infer {
namespace {

void log_to_stderr(int level, const char* module, const char* text) {
  if (level <= WEIR_LOG_WARNING) std::fprintf(stderr, "weir: %s: %s\n", module, text);
}
std::atomic<LogFunction> log_function{log_to_stderr};

std::string text_of(const char* text) {
  return text ? text : "";
}

// The code in what a module returns: any int may come.
int code_of(int result) {
  return result == INT_MIN ? WEIR_INTERNAL : std::abs(result);
}

int fail(weir_error* error, int code, const char* what, const char* offered, const char* needed,
         const char* fix) {
  code = code_of(code);
  if (error) {
    error->error = Error{static_cast<Code>(code),
                         text_of(what),
                         text_of(offered),
                         text_of(needed),
                         "",
                         text_of(fix)};
    error->set = true;
  }
  return -code;
}

void log(int level, const char* module, const char* text) {
  log_function.load()(level, module ? module : "module", text ? text : "");
}

int allocate(void*, uint32_t memory_kind, uint64_t bytes, uint32_t alignment, weir_tensor* out) {
  if (memory_kind != WEIR_MEMORY_HOST || !out) return -WEIR_FORMAT_UNSUPPORTED;
  const uint64_t align = alignment < 64 ? 64 : alignment;
  if ((align & (align - 1)) != 0 || bytes > INT64_MAX - 2 * align) return -WEIR_LIMIT_EXCEEDED;
  const uint64_t capacity = (bytes + align) / align * align;  // at least one byte of padding
  void* data = std::aligned_alloc(align, capacity);
  if (!data) return -WEIR_OUT_OF_MEMORY;
  out->data = data;
  out->bytes = bytes;
  out->capacity = capacity;
  out->owner = data;
  out->release = std::free;
  return WEIR_OK;
}

int sink_set_caps(weir_sink* sink, const char* caps, weir_error* error) {
  const Status status = sink->set_caps(text_of(caps));
  if (status) return WEIR_OK;
  if (error) *error = weir_error{status.error(), true};
  return -static_cast<int>(status.error().code);
}
void* sink_reserve(weir_sink* sink, uint64_t bytes) {
  return sink->reserve(bytes);
}
int sink_share_input(weir_sink* sink, uint32_t index, weir_error* error) {
  const Status status = sink->share_input(index);
  if (status) return WEIR_OK;
  if (error) *error = weir_error{status.error(), true};
  return -static_cast<int>(status.error().code);
}

const weir_sink_calls kSinkCalls{sizeof(weir_sink_calls), sink_set_caps, sink_reserve,
                                 sink_share_input};

const void* extension(const char* id) {
  return id && std::strcmp(id, "weir.sink/1") == 0 ? &kSinkCalls : nullptr;
}

// Asynchronous requests come with the filter's workers; no engine of ABI 0.1 may submit.
void complete(weir_request*, int, weir_frame*, uint32_t, weir_error*) {}
int cancelled(const weir_request*) {
  return 0;
}

const weir_host kHost{sizeof(weir_host), WEIR_ABI_MAJOR, WEIR_ABI_MINOR, fail,     log,
                      allocate,          complete,       cancelled,      extension};

}  // namespace

const weir_host& host() noexcept {
  return kHost;
}

void set_log_function(LogFunction function) noexcept {
  log_function = function ? function : log_to_stderr;
}

Error take_error(weir_error* error, int result, const std::string& fallback) {
  if (error->set) return std::move(error->error);
  return Error{static_cast<Code>(code_of(result)), fallback, "", "", "", ""};
}

}  // namespace weir::infer
