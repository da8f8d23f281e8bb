// nns_log*, and the log lines of this library.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>

#include "compat/guard.hpp"
#include "core/infer/module/host.hpp"
#include "nnstreamer_util.h"
#include "weir/abi.h"

namespace weir::compat {
namespace {

constexpr char kModule[] = "nnstreamer";  // the debug category weir-nnstreamer

void log(int level, const char* format, va_list arguments) noexcept {
  char text[1024];  // on the stack: works without free memory
  if (std::vsnprintf(text, sizeof text, format, arguments) >= 0)
    infer::host().log(level, kModule, text);
}

}  // namespace

void warn(const char* function, const std::string& text) noexcept {
  nns_logw("%s: %s", function, text.c_str());
}
void warn(const char* function, const Error& error) noexcept {
  try {
    infer::host().log(WEIR_LOG_ERROR, kModule,
                      (std::string(function) + ": " + error.message()).c_str());
  } catch (const std::bad_alloc&) {
    infer::host().log(WEIR_LOG_ERROR, kModule, function);
  }
}

}  // namespace weir::compat

#define WEIR_COMPAT_LOG(name, level)             \
  void name(const char* format, ...) {           \
    if (!format) return;                         \
    va_list arguments;                           \
    va_start(arguments, format);                 \
    weir::compat::log(level, format, arguments); \
    va_end(arguments);                           \
  }
WEIR_COMPAT_LOG(nns_logd, WEIR_LOG_DEBUG)
WEIR_COMPAT_LOG(nns_logi, WEIR_LOG_INFO)
WEIR_COMPAT_LOG(nns_logw, WEIR_LOG_WARNING)
WEIR_COMPAT_LOG(nns_loge, WEIR_LOG_ERROR)
