// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/host.hpp"

#include <atomic>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>

#include "core/infer/module/async_request.hpp"
#include "core/infer/module/held_frame.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/process/process_object.hpp"
#include "core/text/text.hpp"
#include "weir/abi.h"

namespace weir::infer {
namespace {

void log_to_stderr(int level, const char* module, const char* text) {
  if (level <= WEIR_LOG_WARNING) std::fprintf(stderr, "weir: %s: %s\n", module, text);
}
struct Log {
  std::atomic<LogFunction> function{log_to_stderr};
};
std::atomic<LogFunction>& log_function() {
  static auto& log = process::object<Log>("log");
  return log.function;
}

// The code of a module's return value, which may be any int.
int to_code(int result) {
  return result == INT_MIN ? WEIR_INTERNAL : std::abs(result);
}
bool is_known(int code) {
#define WEIR_IS_CODE(name, number, title) code == (number) ||
  return WEIR_ERROR_CODES(WEIR_IS_CODE) false;
#undef WEIR_IS_CODE
}

int fail(weir_error* error, int code, const char* what, const char* offered, const char* needed,
         const char* difference, const char* fix) {
  code = to_code(code);
  if (error) {
    error->error = Error{.code = static_cast<Code>(code),
                         .what = or_empty(what),
                         .offered = or_empty(offered),
                         .needed = or_empty(needed),
                         .difference = or_empty(difference),
                         .fix = or_empty(fix)};
    error->set = true;
  }
  return -code;
}

void log(int level, const char* module, const char* text) {
  log_function().load()(level, module ? module : "module", text ? text : "");
}

int allocate(void*, uint32_t memory_kind, uint64_t bytes, uint32_t alignment, weir_tensor* out) {
  if (memory_kind != WEIR_MEMORY_HOST || !out) return -WEIR_FORMAT_UNSUPPORTED;
  const uint64_t align = alignment < 64 ? 64 : alignment;
  if ((align & (align - 1)) != 0 || bytes > INT64_MAX - 2 * align) return -WEIR_LIMIT_EXCEEDED;
  const uint64_t capacity = (bytes + align) / align * align;  // at least one byte of padding
  std::unique_ptr<void, void (*)(void*)> data(std::aligned_alloc(align, capacity), std::free);
  if (!data) return -WEIR_OUT_OF_MEMORY;
  out->bytes = bytes;
  out->capacity = capacity;
  out->release = data.get_deleter();
  out->data = out->owner = data.release();
  return WEIR_OK;
}

int sink_set_caps(weir_sink* sink, const char* caps, weir_error* error) {
  const Status status = sink->set_caps(or_empty(caps));
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

int find_engine(const char* name, const weir_engine** out, weir_error* error) {
  const auto found = ModuleLibrary::instance().engine(or_empty(name));
  *out = found ? *found : nullptr;
  if (found) return WEIR_OK;
  if (error) *error = weir_error{found.error(), true};
  return -static_cast<int>(found.error().code);
}

const weir_engine_finder kFinder{sizeof(weir_engine_finder), find_engine};

const void* extension(const char* id) {
  const std::string_view wanted = id ? id : "";
  if (wanted == "weir.sink/1") return &kSinkCalls;
  if (wanted == WEIR_HOLD_FRAME) return &frame_holder();
  return wanted == WEIR_FIND_ENGINE ? &kFinder : nullptr;
}

void complete(weir_request* request, int status, weir_frame* frame, uint32_t more) {
  complete_request(request, status, frame, more != 0);
}
weir_error* error_of(weir_request* request) {
  return error_of_request(request);
}
int cancelled(const weir_request* request) {
  return is_cancelled(request);
}

const weir_host kHost{sizeof(weir_host), WEIR_ABI_MAJOR, WEIR_ABI_MINOR, fail,      log,
                      allocate,          complete,       error_of,       cancelled, extension};

}  // namespace

const weir_host& host() noexcept {
  return kHost;
}

void set_log_function(LogFunction function) noexcept {
  log_function() = function ? function : log_to_stderr;
}

Error take_error(weir_error* error, int result, const std::string& fallback) {
  if (error->set) return std::move(error->error);
  if (is_known(to_code(result)))
    return Error{.code = static_cast<Code>(to_code(result)), .what = fallback};
  return Error{.code = Code::CALLBACK_FAILED,
               .what = fallback,
               .offered = "it returned " + std::to_string(result),
               .needed = "0, or a code of weir/codes.h below 0 after host->fail with a message"};
}

}  // namespace weir::infer
